// SPDX-License-Identifier: BSD-2-Clause
#include "app/commands/view_argument.h"

#include "app/support/console.h"
#include "app/support/input_error.h"

namespace facet {

void add_view_options(CLI::App& command, ViewArguments& arguments) {
    command
        .add_option("--view", arguments.place,
                    "[ADDRESS:]PORT: show the flight to browsers and to Foxglove, on this computer without an address; "
                    "port 0: any that is free")
        ->type_name("PORT");
    command
        .add_option("--view-token", arguments.token,
                    "File with a word in its first line without which nobody is shown the flight; other addresses "
                    "than loopback need it")
        ->type_name("FILE");
    command.add_option("--view-page", arguments.page, "The page for browsers, which scripts/report --live makes")
        ->type_name("FILE");
}

std::unique_ptr<LiveView> open_view(const ViewArguments& arguments, const StereoRig& rig) {
    if (arguments.place.empty()) {
        if (!arguments.page.empty() || !arguments.token.empty()) {
            throw InputError(fmt::format("--view-{}: needs --view", arguments.page.empty() ? "token" : "page"));
        }
        return nullptr;
    }
    ViewOptions options{.place = parse_view_place(arguments.place), .token = "", .page = arguments.page, .rig = rig};
    if (!arguments.token.empty()) {
        options.token = read_view_token(arguments.token);
    }
    auto view = std::make_unique<LiveView>(options);
    print_err("view: http://{}/{}\n", to_text(view->place()), options.token.empty() ? "" : "#token=THE_TOKEN");
    return view;
}

void print_view(const ViewAccount& account) {
    print_out(
        "view         {} browsers, {} of Foxglove's clients; {} of {} frames passed by, {} messages replaced by newer "
        "ones\n",
        account.viewers, account.foxglove, account.skipped, account.offered, account.replaced);
}

}  // namespace facet
