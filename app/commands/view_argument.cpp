// SPDX-License-Identifier: BSD-2-Clause
#include "app/commands/view_argument.h"

#include "app/support/console.h"
#include "app/support/input_error.h"

namespace facet {

void add_view_options(CLI::App& command, ViewArguments& arguments) {
    command.add_option("--view", arguments.port,
                       "Show the flight in a browser on this computer, at this port; 0: any that is free");
    command.add_option("--view-page", arguments.page, "The page for it, which scripts/report --live makes");
}

std::unique_ptr<LiveView> open_view(const ViewArguments& arguments, const StereoRig& rig) {
    if (!arguments.port) {
        if (!arguments.page.empty()) {
            throw InputError("--view-page: needs --view");
        }
        return nullptr;
    }
    auto view = std::make_unique<LiveView>(ViewOptions{.port = *arguments.port, .page = arguments.page, .rig = rig});
    print_err("view: http://127.0.0.1:{}/\n", view->port());
    return view;
}

void print_view(const ViewAccount& account) {
    print_out(
        "view         {} browsers, {} of Foxglove's clients; {} of {} frames passed by, {} messages replaced by newer "
        "ones\n",
        account.viewers, account.foxglove, account.skipped, account.offered, account.replaced);
}

}  // namespace facet
