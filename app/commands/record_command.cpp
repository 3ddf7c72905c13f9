// SPDX-License-Identifier: BSD-2-Clause
#include "app/commands/record_command.h"

#include <CLI/CLI.hpp>
#include <csignal>
#include <memory>
#include <string>

#include "app/commands/live_command.h"
#include "app/commands/run_guarded.h"
#include "app/commands/stop_signal.h"
#include "app/config/vehicle_file.h"
#include "app/run/hardware.h"
#include "app/run/record_run.h"
#include "app/support/console.h"
#include "app/support/input_error.h"
#include "platform/linux/linux_clock.h"
#include "platform/linux/linux_kernel_io.h"

namespace facet {
namespace {

constexpr Duration kRecordLinePeriod = Duration::from_seconds(5.0);

/// What the user typed.
struct RecordArguments {
    std::string vehicle;
    std::string out;
    std::string form = "folder";
    double duration_s = 0.0;
    bool quiet = false;
};

void print_line(const RecordStatus& status) {
    print_out("{:.0f} s: {} pairs, {} samples; not recorded: {} pairs, {} samples\n", status.duration_s, status.pairs,
              status.samples, status.pairs_dropped, status.samples_dropped);
    std::fflush(stdout);
}

void print_warnings(RecordRun& run) {
    for (const std::string& event : run.take_events()) {
        print_err("warning: {}\n", event);
    }
}

int report(const RecordStatus& status, const RecordRun& run) {
    print_line(status);
    for (const SourceAccount& source : status.sources) {
        print_out("{:<12} {} delivered, {} lost, {} corrupt, {} rejected, {} unmapped\n", source.name,
                  source.counters.delivered, source.counters.lost, source.counters.corrupt, source.rejected,
                  source.unmapped);
    }
    for (const NamedCounter& finding : status.findings) {
        if (finding.value > 0) {
            print_out("{:<12} {} {}\n", "images", finding.value, finding.name);
        }
    }
    print_out("log          {}\n", run.path());
    const char* const lack = status.pairs == 0 ? "no image was recorded" : "";
    return exit_code_for(run.failure().empty() ? lack : run.failure());
}

int record(const RecordArguments& args) {
    require_duration(args.duration_s);
    const LogForm form = parse_log_form(args.form);
    const Vehicle vehicle = load_vehicle(args.vehicle);
    const std::string folder = args.out.empty() ? vehicle.log.folder : args.out;
    if (folder.empty()) {
        throw InputError("no folder; say --out DIR, or sinks.log.folder in the vehicle file");
    }
    LinuxClock clock;
    LinuxKernelIo io;
    Hardware hardware(io, clock, vehicle);
    const std::atomic<bool>& stop = stop_on_signals({SIGINT, SIGTERM, SIGHUP});
    RecordRun run(clock, vehicle, hardware.sources(), folder, form);
    run.start();
    PulseStarter(hardware, vehicle, clock).begin(run.refusals());
    Timestamp next_line = clock.now() + kRecordLinePeriod;
    wait_live(clock, stop, args.duration_s, [&] {
        print_warnings(run);
        if (!args.quiet && clock.now() >= next_line) {
            next_line = next_line + kRecordLinePeriod;
            print_line(run.status());
        }
        return !run.ended();
    });
    end_pulses(hardware);
    const RecordStatus status = run.stop();
    print_warnings(run);
    return report(status, run);
}

}  // namespace

void add_record_command(CLI::App& app, int& exit_code) {
    CLI::App* command = app.add_subcommand("record", "Record live sensors as a log, without estimating");
    auto args = std::make_shared<RecordArguments>();
    command->add_option("--config", args->vehicle, "Vehicle file (YAML), as for facet run")
        ->type_name("FILE")
        ->required();
    command->add_option("--out", args->out, "Folder that gets the log, instead of the vehicle file's sinks.log.folder")
        ->type_name("DIR");
    command->add_option("--format", args->form, kLogFormHelp)->type_name("FORM")->capture_default_str();
    command->add_option("--duration", args->duration_s, "Stop after this long (s); until SIGTERM or Ctrl-C by default")
        ->type_name("SECONDS");
    command->add_flag("--quiet", args->quiet, "No status on stdout until the end");
    command->footer(
        "The log is readable to within a second at every moment, also after a kill, a power failure or on a full "
        "disc.\n"
        "An older log in the folder is never overwritten.\n"
        "Exit codes: 0 stopped in order; 1 no image, or the log could not be written to the end; 2 bad usage, bad "
        "vehicle file, or hardware that is not there.");
    command->callback([args, &exit_code] { exit_code = run_guarded([&] { return record(*args); }); });
}

}  // namespace facet
