// SPDX-License-Identifier: BSD-2-Clause
// What recording costs beside the estimator: plays a log at its pace to the threads of `facet run` and prints the
// processor time of each thread, memory, what was written and what was lost, as JSON.
//
//   recording_load LOG FORM OUT [TURNS]    FORM: none, folder, mcap. TURNS: how often the log is played without a seam,
//                                          which it must be made for (facet sim --closed)
//
// For figures: scripts/benchmark recording. Exit codes: 0 done, nothing lost in the log; 1 not so; 2 bad usage.
#include <dirent.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>

#include "app/run/live_run.h"
#include "app/support/input_error.h"
#include "platform/linux/linux_clock.h"
#include "tests/support/asl_sources.h"
#include "tests/support/stereo_as_camera.h"

namespace facet {
namespace {

/// Processor time of each thread so far by name (s).
std::map<std::string, double> thread_times() {
    std::map<std::string, double> times;
    for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
        std::ifstream name_file(task.path() / "comm");
        std::ifstream stat_file(task.path() / "stat");
        std::string name;
        std::getline(name_file, name);
        const std::string stat{std::istreambuf_iterator<char>(stat_file), {}};
        const std::size_t behind_name = stat.rfind(')');
        if (behind_name == std::string::npos) {
            continue;  // it has ended meanwhile
        }
        std::istringstream fields(stat.substr(behind_name + 2));
        std::string skipped;
        for (int i = 0; i < 11; ++i) {
            fields >> skipped;
        }
        double user = 0.0;
        double system = 0.0;
        fields >> user >> system;
        times[name] += (user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
    }
    return times;
}

double resident_mb() {
    std::ifstream file("/proc/self/statm");
    double total = 0.0;
    double resident = 0.0;
    file >> total >> resident;
    return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) * 1e-6;
}

double size_mb(const std::string& path) {
    std::error_code ignored;
    if (std::filesystem::is_regular_file(path, ignored)) {
        return static_cast<double>(std::filesystem::file_size(path)) * 1e-6;
    }
    double total = 0.0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(path, ignored)) {
        total += entry.is_regular_file() ? static_cast<double>(entry.file_size()) * 1e-6 : 0.0;
    }
    return total;
}

Vehicle vehicle_of(const std::string& log, const std::string& out) {
    Vehicle vehicle;
    vehicle.source = log;
    vehicle.calibration = load_calibration(AslDataset::find_root(log), "", "");
    vehicle.config.imu_noise = vehicle.calibration.noise;
    vehicle.config.regularity.mode = RegularityMode::kSpr;
    vehicle.cameras.side_by_side = true;
    vehicle.log.folder = out;
    // What is kept of a run is full after a minute, so that memory that grows later on is lost memory.
    vehicle.log.timed_frames = 1'000;
    vehicle.log.mesh_faces = 10'000;
    // As in app/config/examples: the recorder gets what all others leave.
    vehicle.realtime.estimator.priority = 10;
    vehicle.realtime.output.priority = 20;
    vehicle.realtime.cameras.priority = 35;
    vehicle.realtime.imu.priority = 45;
    return vehicle;
}

/// The log as it would come from sensors, from half a second from now on.
AslSourceOptions source_of(const std::string& log, int turns, const Clock& clock) {
    AslSourceOptions options;
    options.folder = log;
    options.log.loops = turns;
    AslDataset first;
    std::string error;
    if (!ok(first.open(log, options.log, {}, error))) {
        throw InputError(error);
    }
    options.pace = {first.log_begin(), clock.now() + Duration::from_seconds(2.5), false, false};
    return options;
}

nlohmann::ordered_json play(const std::string& log, std::optional<LogForm> form, const std::string& out, int turns) {
    LinuxClock clock;
    const Vehicle vehicle = vehicle_of(log, out);
    const AslSourceOptions source = source_of(log, turns, clock);
    AslStereoSource stereo(clock, source);
    AslImuSource imu(clock, source);
    const CameraIntrinsics k = vehicle.calibration.rig.left.intrinsics();
    StereoAsCamera<8> camera(stereo, k.width, k.height);
    LiveRun run(clock, vehicle, {&camera, nullptr, nullptr, &imu}, {});
    if (form) {
        run.record(*form);
    }
    run.start();
    std::map<std::string, double> times;
    std::vector<double> resident;
    for (; !run.ended(); clock.sleep(Duration::from_seconds(0.2))) {
        times = thread_times();
        resident.push_back(resident_mb());
    }
    const RunSummary summary = run.stop();
    nlohmann::ordered_json result{{"duration_s", summary.wall_s}, {"frames", summary.frames}};
    for (const auto& [name, time_s] : times) {
        result["processor_s"][name] = time_s;
    }
    result["written_mb"] = !form ? 0.0 : size_mb(out + (*form == LogForm::kMcap ? "/flight.mcap" : "/mav0"));
    result["resident_mb"] = {{"half", resident[resident.size() / 2]}, {"end", resident.back()}};
    std::uint64_t missing = 0;
    for (const NamedCounter& drop : summary.live->drops) {
        result["drops"][drop.name] = drop.value;
        missing += drop.name == "pairs_not_recorded" ? drop.value : 0;
    }
    result["pairs"] = form ? summary.frames_listed - missing : 0;
    result["refusals"] = summary.live->refusals;
    result["failure"] = run.failure();
    return result;
}

int measure(const std::vector<std::string>& words) {
    const std::string& form = words[1];
    const auto* const known = std::find(kLogFormNames.begin(), kLogFormNames.end(), form);
    if (known == kLogFormNames.end() && form != "none") {
        throw InputError(form + ": must be none, folder or mcap");
    }
    const auto chosen =
        form == "none" ? std::nullopt : std::optional(static_cast<LogForm>(known - kLogFormNames.begin()));
    const int turns = words.size() > 3 ? std::stoi(words[3]) : 1;
    const nlohmann::ordered_json result = play(words[0], chosen, words[2], turns);
    std::printf("%s\n", result.dump(1).c_str());
    bool is_complete = result["failure"].get<std::string>().empty();
    for (const auto& [name, value] : result["drops"].items()) {
        is_complete = is_complete && (!name.ends_with("_not_recorded") || value == 0);
    }
    return is_complete ? 0 : 1;
}

}  // namespace
}  // namespace facet

int main(int count, char** arguments) {
    const std::vector<std::string> words(arguments + 1, arguments + count);
    if (words.size() < 3 || words.size() > 4) {
        std::fprintf(stderr, "usage: recording_load LOG none|folder|mcap OUT [TURNS]\n");
        return 2;
    }
    try {
        return facet::measure(words);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "recording_load: %s\n", e.what());
        return 2;
    }
}
