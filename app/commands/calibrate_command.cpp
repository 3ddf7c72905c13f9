// SPDX-License-Identifier: BSD-2-Clause
#include "app/commands/calibrate_command.h"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <memory>

#include "app/commands/run_guarded.h"
#include "app/commands/stop_signal.h"
#include "app/config/calibrated_config.h"
#include "app/config/config_file.h"
#include "app/lab/calibrate/batch.h"
#include "app/lab/calibrate/calibrate.h"
#include "app/lab/convert/opened_log.h"
#include "app/lab/faults/calibration_error.h"
#include "app/lab/faults/fault.h"
#include "app/support/console.h"
#include "app/support/input_error.h"
#include "drivers/replay_asl/asl_dataset.h"
#include "platform/base/angle.h"

namespace facet {
namespace {

/// What the user typed.
struct CalibrateArguments {
    std::string dataset;
    std::string out;
    std::string config;
    std::string cameras;
    std::string imu;
    std::string inject;
    std::vector<std::string> settings;
    double start_s = 0.0;
    double duration_s = 60.0;
    double prior_scale = 1.0;
    bool quiet = false;
};

/// The calibration to start from, with an error if one is asked for.
Calibration given_calibration(const CalibrateArguments& args) {
    const std::string root = AslDataset::find_root(args.dataset);
    if (root.empty()) {
        throw InputError(args.dataset + ": no such folder");
    }
    Calibration calibration = load_calibration(
        root, args.cameras, args.imu, args.cameras.empty() ? ImageExtent{} : extent_of_images(args.dataset, nullptr));
    for (const std::string& remark : calibration.remarks) {
        print_err("warning: {}\n", remark);
    }
    if (!calibration.rig.has_right) {
        throw InputError(args.dataset + ": has one camera; two are calibrated together");
    }
    if (!args.inject.empty()) {
        const Fault fault = parse_fault(args.inject);
        if (fault.kind != FaultKind::kCalibration ||
            !add_calibration_error(fault.values[0], static_cast<std::uint64_t>(fault.values[1]), calibration.rig,
                                   word_of<ErrorDraw>(fault, 2))) {
            throw InputError("--inject " + args.inject +
                             ": must be calibration=K[,SEED[,DRAW]] and leave usable cameras");
        }
    }
    return calibration;
}

int report_calibration(const CalibrateReport& report, const std::string& out) {
    if (!report.refusal.empty()) {
        print_error((report.refusal + "; nothing written").c_str());
        return kExitFailed;
    }
    const Eigen::Vector3d turned_deg = report.motion.turned_rad / kRadPerDeg;
    print_out("flight       {:.1f} s, {:.1f} m, attitude {:.0f}, {:.0f} and {:.0f} deg rms, {} keyframes, {} points\n",
              report.motion.duration_s, report.motion.path_m, turned_deg.x(), turned_deg.y(), turned_deg.z(),
              report.keyframes, report.points);
    print_out("fit          {:.2f} px\n", report.pixel_sigma_px);
    for (const RigParameter& p : report.parameters) {
        print_out("{:<12} {:>12.5f} -> {:>12.5f} +- {:<9.3g} {:<4} {}", p.name, p.given, p.refined, p.sigma,
                  p.unit == "-" ? "" : p.unit, to_string(p.verdict));
        print_out("{}\n", p.verdict == ParameterVerdict::kFound ? "" : ": " + p.advice);
    }
    print_out("files        {}; use them with: facet replay LOG --calibration {}\n", out, out);
    return kExitDone;
}

int run_calibrate(const CalibrateArguments& args) {
    if (!has_batch_solver()) {
        throw InputError("this build cannot calibrate: it was made without Ceres (libceres-dev)");
    }
    if (args.start_s < 0.0 || args.duration_s <= 0.0) {
        throw InputError("--start must not be negative and --duration must be positive");
    }
    CalibrateOptions options;
    RecordingOptions& recording = options.recording;
    recording.dataset = args.dataset;
    recording.calibration = given_calibration(args);
    ProgramConfig config;
    take_calibration(recording.calibration, config);
    if (!args.config.empty()) {
        load_config(args.config, config);
    }
    for (const std::string& setting : args.settings) {
        set_config(setting, config);
    }
    recording.config = config;
    recording.start_s = args.start_s;
    recording.duration_s = args.duration_s;
    recording.show_progress = !args.quiet;
    options.out = args.out;
    options.prior_scale = args.prior_scale;
    return report_calibration(calibrate(options, stop_on_signals({SIGINT, SIGTERM})), args.out);
}

}  // namespace

void add_calibrate_command(CLI::App& app, int& exit_code) {
    CLI::App* command =
        app.add_subcommand("calibrate", "Refine the cameras' calibration from an ordinary flight (EuRoC/ASL folder)");
    auto args = std::make_shared<CalibrateArguments>();
    command->add_option("DATASET", args->dataset, "Folder that holds mav0/, or mav0/ itself (cam0, cam1, imu0)")
        ->required();
    command
        ->add_option("--out", args->out,
                     "Folder for the results: cam0, cam1 and imu0/sensor.yaml, camchain-imucam.yaml, imu.yaml, "
                     "calibration.json, residuals_cam0_before.png, ...")
        ->type_name("DIR")
        ->required();
    command
        ->add_option("--calibration", args->cameras,
                     "Start from Kalibr's camchain.yaml, or a folder with sensor.yaml files, instead of the log's")
        ->type_name("FILE");
    command->add_option("--imu-calibration", args->imu, "Kalibr imu.yaml instead of the log's imu0/sensor.yaml")
        ->type_name("FILE");
    command
        ->add_option("--prior-scale", args->prior_scale,
                     "Widens the uncertainty of the given calibration: at 1, 10 sigma of a good one (focal "
                     "lengths 0.5 %, principal points 3 px, rotations 0.3 deg) and 0.9 mm for the cameras' places")
        ->type_name("FACTOR")
        ->check(CLI::Range(0.01, 100.0))
        ->capture_default_str();
    command->add_option("--start", args->start_s, "Skip this long after the first frame (s)")
        ->type_name("SECONDS")
        ->capture_default_str();
    command->add_option("--duration", args->duration_s, "Use only this much of the log (s)")
        ->type_name("SECONDS")
        ->capture_default_str();
    command->add_option("--config", args->config, "YAML file with parameters of the estimator")->type_name("FILE");
    command->add_option("--set", args->settings, "One parameter on top of --config; may be repeated")
        ->type_name("KEY=VALUE")
        ->allow_extra_args(false);
    command
        ->add_option("--inject", args->inject,
                     "calibration=K[,SEED]: perturbs the given calibration first, as in facet replay")
        ->type_name("FAULT");
    command->add_flag("--quiet", args->quiet, "No progress on stderr");
    command->footer(
        "Exit codes: 0 done; 1 the flight does not determine the calibration (nothing is written); 2 bad usage or "
        "input, or "
        "a build without Ceres.");
    command->callback([args, &exit_code] { exit_code = run_guarded([&] { return run_calibrate(*args); }); });
}

}  // namespace facet
