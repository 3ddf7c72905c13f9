// SPDX-License-Identifier: BSD-2-Clause
// Plays a recorded log through kernel devices into a program that reads them; see scripts/target/hil and docs/hil.md.
#include <fcntl.h>
#include <fmt/core.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/reboot.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>

#include "app/support/text_file.h"
#include "platform/linux/linux_clock.h"
#include "tests/hil/inject/injector.h"

namespace {

using namespace facet;
using namespace facet::hil;

struct Arguments {
    std::string log;
    RecordingPart part;
    std::string imu = "icm42688";
    std::string out;
    std::string states;
    std::string format = "GREY";
    double watchdog_s = 0.0;
    double light_swing = 0.0;
    bool at_once = false;
    std::vector<std::string> faults;
    InjectorOptions options;
    std::vector<std::string> command;
};

ImuKind imu_kind(const std::string& name) {
    return static_cast<ImuKind>(std::find(kImuNames.begin(), kImuNames.end(), name) - kImuNames.begin());
}

/// The program under test gets its signals and its processor when they are due, not when a time slice ends.
void become_punctual() {
    (void)prctl(PR_SET_TIMERSLACK, 1UL);
    sched_param parameters{};
    parameters.sched_priority = 90;
    (void)sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &parameters);
}

void write_report(const std::string& path, const InjectorReport& report, const Child& child, int exit_code) {
    TextFile file(path);
    file.print(
        "{{\"shift_ns\": {}, \"first_frame_ns\": {}, \"frames\": {}, \"imu\": {}, \"latest_ms\": {:.3f}, "
        "\"killed_ns\": {}, \"ready_again_ns\": {}, \"exit_code\": {}, \"greys\": [",
        report.shift.ns, report.first_frame.ns, report.frames_sent, report.imu_sent, report.latest.seconds() * 1e3,
        child.killed_at().ns, child.ready_again_at().ns, exit_code);
    for (std::size_t second = 0; second < report.greys.size(); ++second) {
        const auto& [left, right] = report.greys[second];
        file.print("{}[[{}, {}], [{}, {}]]", second > 0 ? ", " : "", left.median, left.bright, right.median,
                   right.bright);
    }
    file.write("]}\n");
    file.close();
    const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    (void)::fsync(fd);
    (void)::close(fd);
}

/// What the program said of its state each second: seconds since the first frame, MiB resident, its words.
void write_states(const std::string& path, const InjectorReport& report, const Child& child) {
    TextFile file(path);
    file.write("seconds,resident_mib,\"words\"\n");
    for (const ChildState& state : child.states()) {
        file.print("{:.3f},{:.3f},\"{}\"\n", (state.at - (report.first_frame + report.shift)).seconds(),
                   state.resident_mib, state.words);
    }
    file.close();
}

int play(Arguments& args) {
    InjectorOptions& options = args.options;
    options.imu = imu_kind(args.imu);
    options.pixels.format = pixel_format(args.format).value();
    for (const std::string& fault : args.faults) {
        options.faults.add(fault);
    }
    if (args.light_swing > 0.0) {
        options.light.emplace().swing = args.light_swing;
    }
    const Recording recording = load_recording(args.log, args.part);
    options.imu_period = imu_period(recording);
    LinuxClock clock;
    Injector injector(options, recording, clock);
    become_punctual();
    Child child(args.command, Duration::from_seconds(args.watchdog_s), !args.states.empty());
    if (!args.at_once && !child.wait_ready()) {
        fmt::print(stderr, "hil_inject: {} ended with code {} before it was ready\n", args.command.front(),
                   child.stop());
        return 2;
    }
    const InjectorReport report = injector.play(child);
    if (report.power_cut) {
        write_report(args.out, report, child, 0);
        return reboot(RB_POWER_OFF);
    }
    const int exit_code = child.stop();
    if (!args.states.empty()) {
        write_states(args.states, report, child);
    }
    write_report(args.out, report, child, exit_code);
    return exit_code;
}

int encode(const Arguments& args) {
    RecordingPart part = args.part;
    part.images = false;
    const Recording recording = load_recording(args.log, part);
    TextFile file(args.out);
    file.write("#timestamp [ns],w_x [rad s^-1],w_y,w_z,a_x [m s^-2],a_y,a_z\n");
    for (const ImuSample& s : as_encoded(imu_kind(args.imu), recording.imu, imu_period(recording))) {
        file.print("{},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g}\n", s.stamp.ns, s.w_B.x(), s.w_B.y(), s.w_B.z(),
                   s.a_B.x(), s.a_B.y(), s.a_B.z());
    }
    file.close();
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app("Plays a recorded log through the devices of a guest kernel");
    app.require_subcommand(1);
    Arguments args;
    const auto add_common = [&](CLI::App& command) {
        command.add_option("--log", args.log, "Folder in EuRoC/ASL format")->required();
        command.add_option("--start", args.part.start_s, "Seconds of the log to leave out");
        command.add_option("--duration", args.part.duration_s, "Seconds to play; 0 for all");
        command.add_option("--turns", args.part.turns, "How often that is played; it must end as it began")
            ->check(CLI::Range(1, 10000));
        command.add_option("--imu", args.imu, "Sensor that is played")
            ->check(CLI::IsMember(std::vector<std::string>(kImuNames.begin(), kImuNames.end())));
    };
    CLI::App* const play_command = app.add_subcommand("play", "Play, and run a program meanwhile");
    add_common(*play_command);
    play_command->add_option("--fault", args.faults, "KIND@START+LENGTH, seconds from the first frame; repeatable")
        ->take_all();
    play_command->add_option("--format", args.format, "Pixels of both cameras")
        ->check(CLI::IsMember({"GREY", "Y10", "Y10P", "Y12", "Y012", "Y16", "YUYV"}));
    play_command->add_option("--significant-bits", args.options.pixels.significant_bits, "Of Y16");
    play_command->add_flag("--msb-aligned", args.options.pixels.msb_aligned, "Y10, Y12 and Y16 in the high bits");
    play_command->add_option("--light", args.light_swing,
                             "Exposure and gain are the program's; light swings by this factor either way in a minute");
    play_command->add_option("--watchdog", args.watchdog_s, "Seconds after which a silent program is started again");
    play_command->add_option("--left", args.options.left, "Video node")->capture_default_str();
    play_command->add_option("--right", args.options.right, "Video node")->capture_default_str();
    play_command->add_option("--trigger", args.options.trigger_pull, "gpio-sim's pull file of the trigger line")
        ->required();
    play_command->add_option("--data-ready", args.options.data_ready_pull, "... of the inertial sensor's line");
    play_command->add_option("--can", args.options.can_interface, "CAN interface")->capture_default_str();
    play_command->add_option("--report", args.out, "JSON file to write")->required();
    play_command->add_option("--states", args.states, "CSV file to write: what the program says of its state");
    play_command->add_option("command", args.command, "Program and arguments, after --")->required();
    play_command->add_flag("--at-once", args.at_once, "Do not wait until the program says READY=1");
    CLI::App* const encode_command =
        app.add_subcommand("encode", "Write the inertial samples as the sensor rounds them");
    add_common(*encode_command);
    encode_command->add_option("--out", args.out, "data.csv to write")->required();
    CLI::App* const power_off = app.add_subcommand("power-off", "End the guest");
    CLI11_PARSE(app, argc, argv);
    try {
        if (*power_off) {
            return reboot(RB_POWER_OFF);
        }
        return *play_command ? play(args) : encode(args);
    } catch (const std::exception& e) {
        fmt::print(stderr, "hil_inject: {}\n", e.what());
        return 2;
    }
}
