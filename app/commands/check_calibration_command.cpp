// SPDX-License-Identifier: BSD-2-Clause
#include "app/commands/check_calibration_command.h"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "app/commands/run_guarded.h"
#include "app/lab/check/check_calibration.h"
#include "app/lab/convert/opened_log.h"
#include "app/support/console.h"

namespace facet {
namespace {

/// What the user typed.
struct CheckArguments {
    std::string dataset;
    std::string cameras;
    std::string imu;
    std::string json;
};

int run_check(const CheckArguments& args) {
    const OpenedLog log(args.dataset, [](const std::string& line) { print_err("warning: {}\n", line); });
    CheckOptions options;
    options.dataset = args.dataset;
    options.files = log.files();
    options.calibration =
        load_calibration(log.root(), args.cameras, args.imu,
                         args.cameras.empty() ? ImageExtent{} : extent_of_images(args.dataset, log.files()));
    for (const std::string& remark : options.calibration.remarks) {
        print_err("warning: {}\n", remark);
    }
    const std::vector<CheckVerdict> verdicts = check_calibration(options);
    for (const CheckVerdict& verdict : verdicts) {
        print_out("{:<22} {:<12} {}\n", verdict.name, to_string(verdict.level), verdict.sentence);
    }
    if (!args.json.empty()) {
        write_verdicts(verdicts, args.json);
    }
    return has_wrong(verdicts) ? kExitFailed : kExitDone;
}

}  // namespace

void add_check_calibration_command(CLI::App& app, int& exit_code) {
    CLI::App* command = app.add_subcommand(
        "check-calibration", "Check within seconds whether a log's calibration can be correct (EuRoC/ASL folder)");
    auto args = std::make_shared<CheckArguments>();
    command
        ->add_option("DATASET", args->dataset,
                     "Folder that holds mav0/, or mav0/ itself (cam0, cam1, imu0); or an MCAP file of one")
        ->required();
    command->add_option("--calibration", args->cameras, "Instead of the log's: as facet replay has it")
        ->type_name("FILE");
    command->add_option("--imu-calibration", args->imu, "Kalibr imu.yaml instead of the log's imu0/sensor.yaml")
        ->type_name("FILE");
    command->add_option("--json", args->json, "Also write the verdicts with their figures to this file")
        ->type_name("FILE");
    command->footer("Exit codes: 0 nothing is wrong; 1 something is; 2 bad usage or input.");
    command->callback([args, &exit_code] { exit_code = run_guarded([&] { return run_check(*args); }); });
}

}  // namespace facet
