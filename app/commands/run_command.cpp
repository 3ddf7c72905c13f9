// SPDX-License-Identifier: BSD-2-Clause
#include "app/commands/run_command.h"

#include <fmt/core.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdlib>
#include <memory>

#include "app/commands/live_command.h"
#include "app/commands/place_argument.h"
#include "app/commands/run_guarded.h"
#include "app/commands/run_sinks.h"
#include "app/commands/stop_signal.h"
#include "app/commands/stream_argument.h"
#include "app/commands/view_argument.h"
#include "app/config/vehicle_file.h"
#include "app/run/dry_run.h"
#include "app/run/hardware.h"
#include "app/run/live_run.h"
#include "app/run/reset_count.h"
#include "app/run/service_notifier.h"
#include "app/run/signing_time.h"
#include "app/run/state_keeper.h"
#include "app/run/status_text.h"
#include "app/support/console.h"
#include "app/support/input_error.h"
#include "platform/linux/linux_clock.h"
#include "platform/linux/linux_kernel_io.h"

namespace facet {
namespace {

constexpr Duration kRedraw = Duration::from_seconds(0.5);
constexpr Duration kLinePeriod = Duration::from_seconds(10.0);

/// What the user typed.
struct RunArguments {
    std::string vehicle;
    std::string out;
    std::string stream;
    ViewArguments view;
    double duration_s = 0.0;
    bool dry_run = false;
    bool record = false;
    std::string form = "folder";
    PlaceArguments places;
    bool quiet = false;
};

std::string environment(const char* name) {
    const char* const value = std::getenv(name);
    return value == nullptr ? "" : value;
}

int probe(Hardware& hardware, Clock& clock, const Vehicle& vehicle) {
    const std::vector<ProbeLine> lines = dry_run(hardware, clock, vehicle, Duration::from_seconds(1.5));
    print_out("{}", to_text(lines));
    const auto wrong = std::count_if(lines.begin(), lines.end(),
                                     [](const ProbeLine& line) { return line.finding == Finding::kWrong; });
    if (wrong > 0) {
        print_error(fmt::format("{} of {} devices cannot be used", wrong, lines.size()).c_str());
    }
    return wrong > 0 ? kExitBadInput : kExitDone;
}

/// Shows the status on the terminal or, seldom, as a line.
class StatusPrinter {
public:
    StatusPrinter(const Clock& clock, std::string title, bool is_terminal, bool quiet)
        : clock_(clock), title_(std::move(title)), is_terminal_(is_terminal), quiet_(quiet) {}

    void update(LiveRun& run, ServiceNotifier& notifier) {
        if (clock_.now() < next_) {
            return;
        }
        next_ = clock_.now() + (is_terminal_ ? kRedraw : kLinePeriod);
        const RunStatus status = run.status();
        const std::string line = status_line(status);
        notifier.status(line);
        if (quiet_) {
            return;
        }
        if (is_terminal_) {
            print_out("\x1b[H\x1b[2J{}", status_screen(status, title_));
        } else {
            print_out("{}\n", line);
        }
        std::fflush(stdout);
    }

private:
    const Clock& clock_;
    std::string title_;
    bool is_terminal_;
    bool quiet_;
    Timestamp next_;
};

int report(const RunSummary& run, const LiveRun& live) {
    const TimingStatistics latency = timing_statistics(run.live->latency_ms);
    print_out("frames       {} of {} estimated, {} keyframes, path {:.2f} m\n", run.estimates, run.frames_listed,
              run.keyframes, run.path_m);
    print_out("latency      {:.2f} ms median, {:.2f} ms p99; {} overruns\n", latency.median_ms, latency.p99_ms,
              run.live->overruns);
    print_out("end          {}\n", to_string(run.last.health.state));
    if (!live.folder().empty()) {
        print_out("files        {}\n", live.folder());
    }
    const char* const lack = run.not_finite       ? "the estimate became not finite"
                             : run.estimates == 0 ? "no estimate at all"
                                                  : "";
    return exit_code_for(live.failure().empty() ? lack : live.failure());
}

/// The first of the folders that systemd gives under a name; empty if it gives none.
std::string given_folder(const char* variable) {
    const std::string given = environment(variable);
    return given.substr(0, given.find(':'));
}

/// A folder that systemd gives, or else the log's.
std::string folder_or_log(const char* variable, const Vehicle& vehicle) {
    const std::string given = given_folder(variable);
    return given.empty() ? vehicle.log.folder : given;
}

/// In the air it takes a second, and judges masses that the flight moves.
void leave_out_self_test(Vehicle& vehicle) {
    if (vehicle.imu_spi) {
        vehicle.imu_spi->adis16.self_test = false;
        vehicle.imu_spi->icm42688.self_test = false;
        vehicle.imu_spi->bmi088.self_test = false;
    }
}

/// As the option says, else as the vehicle file does.
std::unique_ptr<WorldServer> open_world(const std::string& path, const std::optional<VehicleWorld>& world) {
    return !path.empty() || !world ? open_stream(path)
                                   : open_stream(world->path, {world->group, world->mode}, "sinks.world.path");
}

/// Lets the run go on from what an earlier program has kept a moment ago, and keep what a later one needs.
void resume(LiveRun& run, const StateKeeper& keeper, const Clock& clock) {
    if (keeper.is_in_flight()) {
        run.begin_in_flight();
    }
    run.keep_states();
    std::string refusal;
    const std::optional<StateKeeper::Found> found = keeper.load(clock.now(), refusal);
    if (!refusal.empty()) {
        print_err("the pose begins at the origin: {}\n", refusal);
    } else if (found && ok(run.resume(found->state, found->elapsed_s))) {
        const Eigen::Vector3d& p = found->state.state.p_W_B;
        print_err("goes on from the state of {:.1f} s ago, at {:.2f} {:.2f} {:.2f} m\n", found->elapsed_s, p.x(), p.y(),
                  p.z());
    } else if (found) {
        print_err("the pose begins at the origin: the state that was kept is not fit to go on from\n");
    }
}

void keep_state(LiveRun& run, StateKeeper& keeper, const Clock& clock) {
    KeptState state;
    if (!run.take_state(state)) {
        return;
    }
    if (const std::string problem = keeper.keep(state, clock.now()); !problem.empty()) {
        print_err("warning: the pose will begin at the origin after a restart: {}\n", problem);
    }
}

/// A thread that hangs cannot be ended in order. Whoever supervises starts the program again.
[[noreturn]] void end_stalled(const char* thread) {
    print_error(fmt::format("the thread facet-{} hangs; to be started again", thread).c_str());
    std::_Exit(kExitFailed);
}

/// Says once which thread is silent for more than a second, while the watchdog goes hungry.
class SilenceTeller {
public:
    explicit SilenceTeller(const Clock& clock) : clock_(clock) {}

    void tell(const char* thread) {
        const std::string now = thread == nullptr ? "" : thread;
        if (now != silent_) {
            silent_ = now;
            since_ = clock_.now();
            is_told_ = now.empty();
        } else if (!is_told_ && clock_.now() - since_ > kPatience) {
            is_told_ = true;
            print_err("warning: the thread facet-{} gives no sign of life; the watchdog is not fed\n", silent_);
        }
    }

private:
    static constexpr Duration kPatience = Duration::from_seconds(1.0);
    const Clock& clock_;
    std::string silent_;
    Timestamp since_;
    bool is_told_ = true;
};

int fly(Hardware& hardware, Clock& clock, KernelIo& io, const Vehicle& vehicle, StateKeeper& keeper,
        const RunArguments& args, const std::atomic<bool>& stop) {
    MavlinkLink* const mavlink = hardware.mavlink();
    ResetCount resets(folder_or_log("STATE_DIRECTORY", vehicle));
    SigningTime signing(folder_or_log("STATE_DIRECTORY", vehicle), clock);
    if (mavlink != nullptr) {
        mavlink->begin_signing_at(signing.first());
    }
    bool is_version_said = false;
    const std::vector<OdometrySink*> sinks = open_sinks(hardware, resets, keeper.is_in_flight());
    const bool is_terminal = isatty(STDOUT_FILENO) != 0 && !args.quiet;
    ServiceNotifier notifier(io, clock, environment("NOTIFY_SOCKET"), environment("WATCHDOG_USEC"),
                             environment("WATCHDOG_PID"), getpid());
    const std::unique_ptr<WorldServer> world = open_world(args.stream, vehicle.world);
    const std::unique_ptr<LiveView> view = open_view(args.view, vehicle.calibration.rig);
    LiveRun run(clock, vehicle, hardware.sources(), sinks);
    run.stream_to(world.get());
    run.show_to(view.get());
    run.show_surface_to(view ? &view->surface() : nullptr);
    run.show_to(hardware.ros2_view());
    if (args.record) {
        run.record(parse_log_form(args.form));
    }
    if (is_terminal) {
        run.set_quiet();
    }
    if (args.places.any()) {
        run.remember_places(args.places.known());
    }
    resume(run, keeper, clock);
    run.start();
    PulseStarter pulses(hardware, vehicle, clock);
    pulses.begin(run.refusals(), keeper.is_in_flight());
    notifier.ready();
    StatusPrinter printer(clock, args.vehicle, is_terminal, args.quiet);
    SilenceTeller silences(clock);
    wait_live(clock, stop, args.duration_s, [&] {
        const char* const silent = run.silent_thread();
        if (silent == nullptr) {
            notifier.feed();
        }
        silences.tell(silent);
        keep_resets(hardware, resets);
        keep_state(run, keeper, clock);
        pulses.tick();
        if (const char* const hangs = run.hanging_thread(); hangs != nullptr && notifier.is_watched()) {
            end_stalled(hangs);
        }
        if (mavlink != nullptr) {
            look_after(*mavlink, signing, is_version_said);
            if (mavlink->take_reset_request()) {
                run.request_reset();
            }
        }
        printer.update(run, notifier);
        return !run.ended();
    });
    notifier.stopping();
    end_pulses(hardware);
    const RunSummary summary = run.stop();
    keeper.forget();
    save_places(args.places, run.places());
    print_sinks(hardware);
    if (view) {
        print_view(view->account());
    }
    return report(summary, run);
}

int run_vehicle(const RunArguments& args) {
    require_duration(args.duration_s);
    (void)parse_log_form(args.form);
    Vehicle vehicle = load_vehicle(args.vehicle);
    if (!args.out.empty()) {
        vehicle.log.folder = args.out;
        vehicle.log.by_flight = false;
    }
    if (args.record && vehicle.log.folder.empty()) {
        throw InputError("--record: no folder; say --out DIR, or sinks.log.folder in the vehicle file");
    }
    if (vehicle.mavlink && vehicle.mavlink->in_map && !args.places.any()) {
        throw InputError(fmt::format("{}: sinks.mavlink.frame: 'map' needs --places or --map", args.vehicle));
    }
    StateKeeper keeper(folder_or_log("RUNTIME_DIRECTORY", vehicle), vehicle.calibration, boot_id());
    if (keeper.is_in_flight()) {
        leave_out_self_test(vehicle);
    }
    LinuxClock clock;
    LinuxKernelIo io;
    Hardware hardware(io, clock, vehicle);
    if (args.dry_run) {
        return probe(hardware, clock, vehicle);
    }
    // SIGHUP: the terminal was closed.
    return fly(hardware, clock, io, vehicle, keeper, args, stop_on_signals({SIGINT, SIGTERM, SIGHUP}));
}

}  // namespace

void add_run_command(CLI::App& app, int& exit_code) {
    CLI::App* command = app.add_subcommand("run", "Estimate from live sensors: cameras, IMU, trigger line");
    auto args = std::make_shared<RunArguments>();
    command
        ->add_option("--config", args->vehicle,
                     "Vehicle file (YAML): calibration, sensors, sinks, real-time options; documented examples are in "
                     "app/config/examples")
        ->type_name("FILE")
        ->required();
    command
        ->add_option("--out", args->out,
                     "Folder for the files of this flight, instead of a new one in the vehicle file's sinks.log.folder")
        ->type_name("DIR");
    command->add_option("--stream", args->stream, kStreamHelp)->type_name("PATH");
    add_view_options(*command, args->view);
    add_place_options(*command,
                      "Remember places and recognise them again: sinks.ros2 then publishes the transform from odom to "
                      "map (REP-105); poses themselves never jump",
                      args->places);
    command->add_option("--duration", args->duration_s, "Stop after this long (s); until SIGTERM or Ctrl-C by default")
        ->type_name("SECONDS");
    command->add_flag("--dry-run", args->dry_run, "Only try the hardware: prints one line per device");
    command->add_flag("--record", args->record,
                      "Also write what the estimator is given, as a log in that folder, for facet replay");
    command->add_option("--format", args->form, kLogFormHelp)->type_name("FORM")->capture_default_str();
    command->add_flag("--quiet", args->quiet, "No status on stdout");
    command->footer(
        "SIGTERM and SIGINT stop in order: what was estimated is sent, files are complete, summary.json is written.\n"
        "As a systemd service of Type=notify it reports READY, STATUS and STOPPING, and feeds the watchdog while "
        "inertial samples come and estimator and sinks are at work.\n"
        "Exit codes: 0 stopped in order; 1 no estimate, not finite, or a file could not be written; 2 bad usage, bad "
        "vehicle file, or hardware that is not there.");
    command->callback([args, &exit_code] { exit_code = run_guarded([&] { return run_vehicle(*args); }); });
}

}  // namespace facet
