// SPDX-License-Identifier: BSD-2-Clause
// The program: its commands and its exit codes.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <string>

#include "app/commands/build_version.h"
#include "app/commands/calibrate_command.h"
#include "app/commands/calibration_command.h"
#include "app/commands/check_calibration_command.h"
#include "app/commands/check_config_command.h"
#include "app/commands/convert_command.h"
#include "app/commands/eval_command.h"
#include "app/commands/help_formatter.h"
#include "app/commands/info_command.h"
#include "app/commands/map_command.h"
#include "app/commands/record_command.h"
#include "app/commands/replay_command.h"
#include "app/commands/report_command.h"
#include "app/commands/run_command.h"
#include "app/commands/run_guarded.h"
#include "app/commands/sim_command.h"
#include "app/support/console.h"

namespace {

bool is_command(const CLI::App& app, const std::string& name) {
    const auto commands = app.get_subcommands([](const CLI::App*) { return true; });
    return std::any_of(commands.begin(), commands.end(),
                       [&](const CLI::App* command) { return command->get_name() == name; });
}

/// @return the exit code
int run_program(int argc, char** argv) {
    CLI::App app("facet: stereo visual-inertial estimator", "facet");
    app.formatter(std::make_shared<facet::HelpFormatter>());  // that of all commands
    app.set_version_flag("--version", facet::build_version(), "Version, commit, compiler, target and flags");
    app.require_subcommand(1);
    app.footer(
        "Each command explains itself: facet COMMAND --help.\n"
        "Exit codes: 0 done; 1 ran but failed its purpose; 2 bad usage or input.");
    int exit_code = facet::kExitDone;
    facet::add_run_command(app, exit_code);
    facet::add_record_command(app, exit_code);
    facet::add_replay_command(app, exit_code);
    facet::add_eval_command(app, exit_code);
    facet::add_report_command(app, exit_code);
    facet::add_check_calibration_command(app, exit_code);
    facet::add_calibration_command(app, exit_code);
    facet::add_check_config_command(app, exit_code);
    facet::add_calibrate_command(app, exit_code);
    facet::add_convert_command(app, exit_code);
    facet::add_map_command(app, exit_code);
    facet::add_sim_command(app, exit_code);
    facet::add_info_command(app, exit_code);
    if (argc > 1 && argv[1][0] != '-' && !is_command(app, argv[1])) {
        facet::print_error((std::string(argv[1]) + ": no such command; facet --help lists them").c_str());
        return facet::kExitBadInput;
    }
    if (argc > 1 && argv[1][0] == '-' && app.get_option_no_throw(argv[1]) == nullptr) {
        facet::print_error((std::string(argv[1]) + ": no such option; facet --help lists them").c_str());
        return facet::kExitBadInput;
    }
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& e) {
        if (e.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) {
            return app.exit(e);  // help or version
        }
        facet::print_error(e.what());
        return facet::kExitBadInput;
    }
    return exit_code;
}

}  // namespace

int main(int argc, char** argv) {
    facet::prepare_console();
    const int exit_code = facet::run_guarded([&] { return run_program(argc, argv); });
    if (!facet::finish_console()) {
        facet::print_error("standard output: cannot be written");
        return exit_code == facet::kExitDone ? facet::kExitFailed : exit_code;
    }
    return exit_code;
}
