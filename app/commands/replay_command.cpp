// SPDX-License-Identifier: BSD-2-Clause
#include "app/commands/replay_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <memory>

#include "app/commands/mavlink_argument.h"
#include "app/commands/place_argument.h"
#include "app/commands/run_guarded.h"
#include "app/commands/stop_signal.h"
#include "app/commands/stream_argument.h"
#include "app/commands/view_argument.h"
#include "app/config/calibrated_config.h"
#include "app/config/config_file.h"
#include "app/lab/check/check_calibration.h"
#include "app/lab/convert/opened_log.h"
#include "app/lab/faults/fault.h"
#include "app/lab/replay/estimate_file.h"
#include "app/lab/replay/replay.h"
#include "app/output/coverage.h"
#include "app/support/console.h"
#include "app/support/input_error.h"
#include "platform/linux/linux_clock.h"
#include "platform/linux/linux_kernel_io.h"

namespace facet {
namespace {

/// What the user typed.
struct ReplayArguments {
    std::string dataset;
    std::string mode = "s";
    std::string out;
    std::string config;
    std::string cameras;
    std::string imu;
    std::vector<std::string> masks;
    std::vector<std::string> settings;
    std::vector<std::string> faults;
    double start_s = 0.0;
    double duration_s = 0.0;
    int loops = 1;
    int passes = 1;
    double min_coverage = kMinCoverage;
    std::string truth;
    std::string rate = "frames";
    std::string mavlink;
    bool write_rays = false;
    bool write_fused = false;
    bool write_calibration = false;
    PlaceArguments places;
    ViewArguments view;
    std::string stream;
    std::string mcap;
    bool in_real_time = false;
    bool quiet = false;
};

RegularityMode parse_mode(const std::string& text) {
    const auto* const name = std::ranges::find(kRegularityModeNames, text);
    if (name == kRegularityModeNames.end()) {
        throw InputError(
            fmt::format("--mode {}: unknown; must be one of: {}", text, fmt::join(kRegularityModeNames, ", ")));
    }
    return static_cast<RegularityMode>(name - kRegularityModeNames.begin());
}

/// What the log itself shows to be wrong, as a cause of a run that failed.
void print_causes(const ReplayOptions& options) {
    try {
        for (const CheckVerdict& verdict : check_calibration({options.dataset, options.calibration, options.files})) {
            if (verdict.level == CheckLevel::kWrong) {
                print_err("facet: the log shows a cause: {}: {}\n", verdict.name, verdict.sentence);
            }
        }
    } catch (const InputError&) {  // too little of a log to be checked
    }
}

int report(const RunSummary& run, const ReplayOptions& options, double min_coverage) {
    std::vector<double> processor_ms;
    std::vector<double> wall_ms;
    for (const RunSummary::TimedFrame& frame : run.timed) {
        processor_ms.push_back(frame.timing.total.processor_ms);
        wall_ms.push_back(frame.timing.total.wall_ms);
    }
    const TimingStatistics processor = timing_statistics(std::move(processor_ms));
    const TimingStatistics wall = timing_statistics(std::move(wall_ms));
    std::size_t warnings = 0;
    for (const auto& [kind, count] : run.warnings) {
        warnings += count;
    }
    print_out("frames       {} of {} estimated ({:.1f} %), {} keyframes, path {:.2f} m\n", run.estimates,
              run.frames_listed, 100.0 * run.coverage(), run.keyframes, run.path_m);
    print_out("time         per frame {:.2f} ms of CPU in the mean, {:.2f} ms p99; elapsed {:.2f} ms, {:.2f} ms p99\n",
              processor.mean_ms, processor.p99_ms, wall.mean_ms, wall.p99_ms);
    print_out("end          {}{}, {} warnings\n", to_string(run.last.health.state),
              run.interrupted ? " (interrupted)" : "", warnings);
    print_out("files        {}\n", options.out);
    if (run.not_finite) {
        print_error("the estimate became not finite");
    } else if (run.interrupted) {
        print_error("interrupted; files are complete up to here");
    } else if (const std::string loss = describe_lost_coverage(run, min_coverage); !loss.empty()) {
        print_error(loss.c_str());
        print_causes(options);
    } else if (const std::string contradiction = describe_contradiction(run); !contradiction.empty()) {
        print_error(contradiction.c_str());
        print_causes(options);
    } else if (run.last.health.state == TrackingState::kLost) {
        print_error("lost at the end");
    } else {
        return kExitDone;
    }
    return kExitFailed;
}

/// A path that begins with the log's, as if an MCAP file were a folder.
std::string path_in(const OpenedLog& log, const std::string& dataset, const std::string& path) {
    const bool is_inside = log.files() != nullptr && path.starts_with(dataset + "/");
    return is_inside ? log.folder() + path.substr(dataset.size()) : path;
}

ReplayOptions read_options(const ReplayArguments& args, const OpenedLog& log, bool has_duration) {
    const RegularityMode mode = parse_mode(args.mode);
    constexpr double kMax_s = 1e9;  // nanoseconds stay far from overflow
    if (!(args.start_s >= 0.0 && args.start_s <= kMax_s) ||
        (has_duration && !(args.duration_s > 0.0 && args.duration_s <= kMax_s))) {
        throw InputError("--start must not be negative, --duration must be positive, and both at most 1e9 s");
    }
    ReplayOptions options;
    options.dataset = args.dataset;
    options.files = log.files();
    options.truth_folder = log.folder();
    options.out = args.out;
    if (args.out.empty()) {
        throw InputError(
            fmt::format("--out is missing, the folder for the results: facet replay {} --out result", args.dataset));
    }
    options.calibration =
        load_calibration(log.root(), args.cameras, args.imu,
                         args.cameras.empty() ? ImageExtent{} : extent_of_images(args.dataset, log.files()));
    for (const std::string& remark : options.calibration.remarks) {
        print_err("warning: {}\n", remark);
    }
    if (!args.masks.empty()) {
        options.calibration.masks = {args.masks.front(), args.masks.size() > 1 ? args.masks.back() : ""};
    }
    take_calibration(options.calibration, options.config);
    if (!args.config.empty()) {
        load_config(path_in(log, args.dataset, args.config), options.config);
    }
    for (const std::string& setting : args.settings) {
        set_config(setting, options.config);
    }
    options.config.regularity.mode = mode;
    for (const std::string& spec : args.faults) {
        options.faults.push_back(parse_fault(spec));
    }
    if (args.rate != "frames" && args.rate != "imu") {
        throw InputError(fmt::format("--rate {}: unknown; must be one of: frames, imu", args.rate));
    }
    options.at_imu_rate = args.rate == "imu";
    options.start_s = args.start_s;
    options.duration_s = has_duration ? std::optional<double>(args.duration_s) : std::nullopt;
    options.loops = args.loops;
    options.passes = args.passes;
    if (options.loops > 1 && (options.passes > 1 || options.start_s > 0.0 || has_duration)) {
        throw InputError("--loops: repeats the whole log, without --start, --duration and --passes");
    }
    options.truth = parse_truth(args.truth);
    if (options.truth.any() && (options.passes > 1 || options.loops > 1)) {
        throw InputError("--truth: the ground truth covers one pass only");
    }
    if (options.truth.planes && mode != RegularityMode::kSpr) {
        throw InputError("--truth planes: only --mode spr uses planes");
    }
    if (options.truth.any() && std::any_of(options.faults.begin(), options.faults.end(), shifts_stamps)) {
        throw InputError("--truth: with stamps that --inject has shifted, the truth of another time would be found");
    }
    options.write_rays = args.write_rays;
    options.write_fused = args.write_fused;
    options.write_calibration = args.write_calibration;
    options.keep_places = args.places.any();
    options.load_map = args.places.load;
    options.save_map = args.places.save;
    options.show_progress = !args.quiet;
    options.in_real_time = args.in_real_time;
    return options;
}

int replay(const ReplayArguments& args, bool has_duration) {
    const OpenedLog log(args.dataset, [](const std::string& line) { print_err("warning: {}\n", line); });
    ReplayOptions options = read_options(args, log, has_duration);
    LinuxClock clock;
    LinuxKernelIo io;
    const std::unique_ptr<MavlinkLink> link = open_mavlink(args.mavlink, io, clock);
    options.sink = link.get();
    const std::unique_ptr<WorldServer> world = open_stream(args.stream);
    options.world = world.get();
    const std::unique_ptr<LiveView> view = open_view(args.view, options.calibration.rig);
    options.viewers.push_back(view.get());
    options.surface = view ? &view->surface() : nullptr;
    const auto estimates = args.mcap.empty() ? nullptr : std::make_unique<EstimateFile>(args.mcap);
    options.viewers.push_back(estimates.get());
    const RunSummary run = run_replay(options, stop_on_signals({SIGINT, SIGTERM, SIGHUP}));
    if (estimates) {
        estimates->close();
    }
    const int code = report(run, options, args.min_coverage);
    if (link) {
        print_out("mavlink      {} sent, {} dropped\n", link->counters().sent, link->counters().dropped);
    }
    if (view) {
        print_view(view->account());
    }
    if (args.in_real_time) {
        print_out("real time    at most {:.3f} s behind the log\n", run.greatest_lag_s);
    }
    return code;
}

}  // namespace

void add_replay_command(CLI::App& app, int& exit_code) {
    CLI::App* command =
        app.add_subcommand("replay", "Run a recorded log (EuRoC/ASL folder, or its MCAP file) through the estimator");
    auto args = std::make_shared<ReplayArguments>();
    command
        ->add_option("DATASET", args->dataset,
                     "Folder that holds mav0/, or mav0/ itself (cam0, cam1, imu0); or an MCAP file of one")
        ->required();
    command
        ->add_option("--out", args->out,
                     "Folder for the results, created if missing: trajectory.tum, trajectory.csv, covariance.csv, "
                     "timing.csv, health.csv, mesh.ply, mesh_live.ply, mesh.csv, planes.csv, planes.json, "
                     "residuals.csv, summary.json, warnings.txt")
        ->type_name("DIR");
    command
        ->add_option("--mode", args->mode,
                     "s: landmarks only, planes are found and reported; spr: planes found in the mesh constrain their "
                     "landmarks; sp: as s, but for window.published_weights")
        ->type_name("MODE")
        ->capture_default_str();
    command
        ->add_option(
            "--config", args->config,
            "YAML file with parameters; 'facet info --config' prints all with defaults. May be in the log's MCAP "
            "file: LOG.mcap/mav0/parameters.yaml")
        ->type_name("FILE");
    command->add_option("--set", args->settings, "One parameter on top of --config; may be repeated")
        ->type_name("KEY=VALUE")
        ->allow_extra_args(false);
    CLI::Option* start =
        command->add_option("--start", args->start_s, "Skip this long after the first frame (s)")->type_name("SECONDS");
    start->capture_default_str();
    CLI::Option* duration =
        command->add_option("--duration", args->duration_s, "Use only this much of the log (s); all by default")
            ->type_name("SECONDS");
    command
        ->add_option(
            "--loops", args->loops,
            "Repeat a log that ends as it began (facet sim --closed) this many times without a seam: time goes on")
        ->type_name("N")
        ->check(CLI::Range(1, 100'000))
        ->capture_default_str();
    command
        ->add_option(
            "--passes", args->passes,
            "Play the log this many times, with 5 s without samples in between, after which the lost estimator "
            "starts again (endurance)")
        ->type_name("N")
        ->check(CLI::Range(1, 100'000))
        ->capture_default_str();
    command
        ->add_option(
            "--calibration", args->cameras,
            "Instead of the log's: a file of Kalibr or OpenVINS (camera chain with T_cam_imu or T_imu_cam), Basalt, "
            "ORB-SLAM3, OKVIS2, VINS-Fusion, RealSense or OAK; or a folder with cam0, cam1 and imu0/sensor.yaml, such "
            "as "
            "facet calibrate leaves, or with Kimera's files")
        ->type_name("FILE");
    command
        ->add_option("--imu-calibration", args->imu,
                     "Kalibr or OpenVINS imu.yaml instead of the log's imu0/sensor.yaml")
        ->type_name("FILE");
    command
        ->add_option("--mask", args->masks,
                     "LEFT.png [RIGHT.png]: pictures of the cameras' sizes, black where they see the vehicle itself; "
                     "instead of mask.png beside each camera's sensor.yaml")
        ->type_name("FILE")
        ->expected(1, 2);
    command
        ->add_option(
            "--inject", args->faults,
            "NAME[=VALUE][@START[+LENGTH]]: a fault between log and estimator; may be repeated. 'facet info --faults' "
            "lists them")
        ->type_name("FAULT")
        ->allow_extra_args(false);
    command
        ->add_option("--truth", args->truth,
                     "Comma-separated list of tracks, stereo, bias and planes: these are replaced by the dataset's "
                     "ground truth, to "
                     "see what their errors cost. All but bias need its truth/scene.ply, planes also truth/planes.json")
        ->type_name("KINDS");
    command
        ->add_option(
            "--min-coverage", args->min_coverage,
            "Exit with code 1 if less than this share of the frames since the first estimate, or less than half "
            "of it of all frames, has an estimate")
        ->type_name("SHARE")
        ->check(CLI::Range(0.0, 1.0))
        ->capture_default_str();
    command
        ->add_option("--rate", args->rate,
                     "frames: the trajectory's files have a line for every frame; imu: for every inertial sample, the "
                     "newest estimate carried on to it as on the vehicle")
        ->type_name("RATE")
        ->capture_default_str();
    command
        ->add_option("--mavlink", args->mavlink,
                     "Send the estimates: udp:HOST:PORT (IPv4 address) or serial:DEVICE[:BAUD]. Stamps are those of "
                     "the log; one ODOMETRY for every line of the trajectory")
        ->type_name("LINK");
    command->add_option("--stream", args->stream, kStreamHelp)->type_name("PATH");
    command->add_flag(
        "--rays", args->write_rays,
        "Also write grid.png, a picture of the live grid at the end, and rays.csv and sweeps.csv: what it reports "
        "along rays, and the distances all around, at each keyframe, for facet eval --scene");
    command->add_flag("--fuse", args->write_fused,
                      "Also write mesh_fused.ply: one mesh of the whole run, from the depth of every keyframe's pixels "
                      "and with its final pose; takes about ten times the CPU time of the estimator");
    command->add_flag("--log-calibration", args->write_calibration,
                      "Also write calibration.csv: corrections of the calibration with sigmas at each keyframe");
    add_place_options(*command,
                      "Remember places and recognise them again: also write places.csv, and trajectory_map.tum, the "
                      "flight in the map of these places, free of the drift of trajectory.tum",
                      args->places);
    add_view_options(*command, args->view);
    command
        ->add_option("--mcap", args->mcap,
                     "Also write the estimates into this MCAP file, for Foxglove and similar viewers: pose, path, "
                     "mesh, planes, health, times, calibration, and a small left image")
        ->type_name("FILE");
    command->add_flag("--realtime", args->in_real_time, "No faster than the log was recorded");
    command->add_flag("--quiet", args->quiet, "No progress on stderr");
    command->footer(
        "Exit codes: 0 done; 1 too few frames with an estimate, sensors that contradict each other, lost at the end, "
        "not finite, or interrupted; 2 bad usage or input.");
    command->callback([args, duration, &exit_code] {
        exit_code = run_guarded([&] { return replay(*args, duration->count() > 0); });
    });
}

}  // namespace facet
