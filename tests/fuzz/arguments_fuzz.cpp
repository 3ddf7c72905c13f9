// SPDX-License-Identifier: BSD-2-Clause
// The command line: every argument is a line of the input. It is read, but no command is run.
#include <CLI/CLI.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "app/commands/calibrate_command.h"
#include "app/commands/check_calibration_command.h"
#include "app/commands/check_config_command.h"
#include "app/commands/convert_command.h"
#include "app/commands/eval_command.h"
#include "app/commands/info_command.h"
#include "app/commands/record_command.h"
#include "app/commands/replay_command.h"
#include "app/commands/report_command.h"
#include "app/commands/run_command.h"
#include "app/commands/sim_command.h"
#include "app/support/input_error.h"
#include "tests/fuzz/fuzz_input.h"

using namespace facet;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    CLI::App app("facet", "facet");
    app.require_subcommand(1);
    int exit_code = -1;
    for (auto* const add : {&add_run_command, &add_record_command, &add_replay_command, &add_eval_command,
                            &add_report_command, &add_check_calibration_command, &add_check_config_command,
                            &add_calibrate_command, &add_convert_command, &add_sim_command, &add_info_command}) {
        add(app, exit_code);
    }
    // Before the command would run; its callback owns the arguments, and has to stay.
    app.parse_complete_callback([] { throw CLI::Success(); });
    std::istringstream lines(std::string(test::FuzzInput(data, size).rest_as_text()));
    std::vector<std::string> arguments;
    for (std::string line; arguments.size() < 64 && std::getline(lines, line, '\n');) {
        arguments.insert(arguments.begin(), line);  // CLI11 takes them from the back
    }
    try {
        app.parse(arguments);
    } catch (const CLI::ParseError& e) {
        test::require(e.what() != nullptr);
    } catch (const InputError&) {  // a validator of our own
    }
    test::require(exit_code == -1);
    return 0;
}
