// SPDX-License-Identifier: BSD-2-Clause
// A log played through `facet record`'s threads is the log that they leave.
#include "app/run/record_run.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <filesystem>
#include <map>
#include <sstream>

#include "app/lab/mcap/mcap_file.h"
#include "drivers/replay_asl/asl_dataset.h"
#include "platform/linux/linux_clock.h"
#include "tests/support/asl_folder.h"
#include "tests/support/asl_sources.h"
#include "tests/support/paced_sources.h"
#include "tests/support/stereo_as_camera.h"

namespace facet::record_run_test {
namespace {

/// What a log gives: inertial samples and pairs, as text.
struct Content {
    std::vector<std::string> samples;
    std::vector<std::string> pairs;
    int warnings = 0;
};

Content content_of(const std::string& folder) {
    Content content;
    AslDataset log;
    std::string error;
    const Status opened = log.open(
        folder, {}, [&](const AslWarning&) { ++content.warnings; }, error);
    INFO(error);
    REQUIRE(ok(opened));
    ImuSample sample;
    StereoFrame frame;
    for (;;) {
        switch (log.next(sample, frame)) {
            case AslDataset::Event::kImu:
                content.samples.push_back(std::to_string(sample.stamp.ns) + " " + std::to_string(sample.a_B.z()));
                break;
            case AslDataset::Event::kFrame: {
                std::string text = std::to_string(frame.stamp.ns);
                for (const ImageView& view : {frame.left, frame.right}) {
                    for (int v = 0; v < view.height; ++v) {
                        text.append(reinterpret_cast<const char*>(view.row(v)), static_cast<std::size_t>(view.width));
                    }
                }
                content.pairs.push_back(text);
                break;
            }
            case AslDataset::Event::kEnd: return content;
        }
    }
}

/// A log as the sensors of a vehicle: one camera with both views side by side, an IMU.
class Bench {
public:
    Bench(const std::string& log, Clock& clock, int loops = 1)
        : stereo_(clock, options(log, loops)), imu_(clock, options(log, loops)) {
        vehicle_.calibration = load_euroc_calibration(log + "/mav0");
        vehicle_.cameras.side_by_side = true;
        vehicle_.cameras.rate_hz = 20.0;
    }
    const Vehicle& vehicle() const { return vehicle_; }
    RunSources sources() {
        RunSources sources;
        sources.left = &paced_camera_;
        sources.imu = &paced_imu_;
        return sources;
    }

private:
    static AslSourceOptions options(const std::string& log, int loops) {
        AslSourceOptions options;
        options.folder = log;
        options.log.loops = loops;
        options.pace.as_fast_as_asked = true;
        return options;
    }

    Vehicle vehicle_;
    Pace pace_{1, Duration::from_seconds(0.2)};
    AslStereoSource stereo_;
    AslImuSource imu_;
    StereoAsCamera<4> camera_{stereo_, test::kAslWidth, test::kAslHeight};
    PacedCamera paced_camera_{camera_, pace_, 0};
    PacedImu paced_imu_{imu_, pace_};
};

TEST_CASE("what the sensors gave is in the log, and the calibration beside it") {
    const test::TempDir made;
    const test::TempDir dir;
    test::write_asl_folder(made, 30);
    StillClock clock;
    Bench bench(made.path(), clock);
    RecordRun run(clock, bench.vehicle(), bench.sources(), dir.path(), LogForm::kFolder);
    run.start();
    LinuxClock patience;
    for (int i = 0; i < 1200 && !run.ended(); ++i) {
        patience.sleep(Duration::from_seconds(0.05));
    }
    REQUIRE(run.ended());
    const RecordStatus status = run.stop();
    CHECK(run.failure().empty());
    CHECK(status.pairs == 30);
    CHECK(status.pairs_dropped == 0);
    CHECK(status.samples_dropped == 0);
    CHECK(run.take_events().empty());
    REQUIRE(status.sources.size() == 2);
    CHECK(status.sources[0].name == "cameras");

    const Content before = content_of(made.path());
    const Content after = content_of(dir.path());
    CHECK(after.pairs == before.pairs);
    CHECK(after.samples.size() == status.samples);
    CHECK(std::equal(after.samples.begin(), after.samples.end(), before.samples.begin()));
    CHECK(after.samples.size() > 280);
    CHECK(after.warnings == 0);
    for (const char* file : {"mav0/cam0/sensor.yaml", "mav0/cam1/sensor.yaml", "mav0/imu0/sensor.yaml"}) {
        CHECK(test::read_file(dir.file(file)) == test::read_file(made.file(file)));
    }
    CHECK(std::filesystem::exists(dir.file("mav0/parameters.yaml")));

    // There is a log already.
    Bench again(made.path(), clock);
    RecordRun second(clock, again.vehicle(), again.sources(), dir.path(), LogForm::kFolder);
    CHECK_THROWS(second.start());
    CHECK(content_of(dir.path()).pairs == before.pairs);
}

TEST_CASE("readings of a range finder are in the log, with the frame before which they came") {
    const test::TempDir made;
    const test::TempDir dir;
    test::write_asl_folder(made, 30);
    StillClock clock;
    Bench bench(made.path(), clock);
    RangeQueue ranges;
    for (int i = 0; i < 5; ++i) {
        REQUIRE(ok(ranges.push({{1'000 + i}, {0.0, 0.1, -1.5 - i}})));
    }
    RunSources sources = bench.sources();
    sources.ranges = &ranges;
    RecordRun run(clock, bench.vehicle(), sources, dir.path(), LogForm::kFolder);
    run.start();
    LinuxClock patience;
    for (int i = 0; i < 1200 && !run.ended(); ++i) {
        patience.sleep(Duration::from_seconds(0.05));
    }
    REQUIRE(run.ended());
    CHECK(run.stop().samples_dropped == 0);
    std::istringstream rows(test::read_file(dir.file("mav0/range0/data.csv")));
    std::vector<std::string> lines;
    for (std::string line; std::getline(rows, line);) {
        lines.push_back(line);
    }
    REQUIRE(lines.size() == 6);
    const std::string first = content_of(dir.path()).pairs.front();
    const std::string first_frame = first.substr(0, first.find_first_not_of("0123456789"));
    for (int i = 0; i < 5; ++i) {
        CAPTURE(lines[static_cast<std::size_t>(i) + 1]);
        CHECK(lines[static_cast<std::size_t>(i) + 1].starts_with(std::to_string(1'000 + i) + ",0,0.1"));
        CHECK(lines[static_cast<std::size_t>(i) + 1].ends_with("," + first_frame));
    }
}

TEST_CASE("of a flight of minutes everything is in the file, or counted") {
    constexpr int kLoops = 8;
    constexpr int kPairs = 400;
    const test::TempDir made;
    const test::TempDir dir;
    test::write_asl_folder(made, kPairs);
    LinuxClock clock;  // on which the file is committed twice a second
    Bench bench(made.path(), clock, kLoops);
    RecordRun run(clock, bench.vehicle(), bench.sources(), dir.path(), LogForm::kMcap);
    run.start();
    for (int i = 0; i < 6000 && !run.ended(); ++i) {
        clock.sleep(Duration::from_seconds(0.02));
    }
    REQUIRE(run.ended());
    const RecordStatus status = run.stop();
    CHECK(run.failure().empty());
    CHECK(status.pairs + status.pairs_dropped == kLoops * kPairs);  // the sources do not wait for the disc
    CHECK(status.pairs > kPairs);
    CHECK(run.path() == dir.file("flight.mcap"));
    McapFile file(run.path(), [](const std::string& line) { FAIL(line); });
    CHECK(file.is_whole());
    CHECK(file.attachments().size() == 4);  // three of the calibration, and the parameters
    std::map<std::string, std::uint64_t> counts;
    std::string drops;
    McapFile::Cursor cursor;
    for (McapMessage message; file.next(cursor, message);) {
        const std::string& topic = file.channels().at(message.channel).topic;
        ++counts[topic];
        drops = topic == "/drops" ? std::string(message.data.begin(), message.data.end()) : drops;
    }
    for (const char* topic : {"/cam0", "/cam1", "/pairs"}) {
        CHECK(counts[topic] == status.pairs);
    }
    CHECK(counts["/imu0"] == status.samples - status.samples_dropped);
    CHECK(counts["/drops"] > kLoops * kPairs / 20 / 2);  // one a second
    CHECK(counts["/pose"] == 0);
    CHECK(drops.find(R"("cameras_lost":0)") != std::string::npos);
    CHECK(drops.find(R"("pairs_not_recorded":)") != std::string::npos);
}

TEST_CASE("a full disk ends the recording and leaves a readable log") {
    const test::TempDir made;
    const test::TempDir dir;
    test::write_asl_folder(made, 400);
    const pid_t child = fork();
    REQUIRE(child >= 0);
    if (child == 0) {
        // No file can grow beyond this: inertial rows need more.
        const rlimit limit{40'000, 40'000};
        (void)std::signal(SIGXFSZ, SIG_IGN);
        (void)setrlimit(RLIMIT_FSIZE, &limit);
        LinuxClock clock;
        Bench bench(made.path(), clock);
        RecordRun run(clock, bench.vehicle(), bench.sources(), dir.path(), LogForm::kFolder);
        run.start();
        for (int i = 0; i < 600 && !run.ended(); ++i) {
            clock.sleep(Duration::from_seconds(0.05));
        }
        (void)run.stop();
        _exit(run.failure().find("cannot be written") != std::string::npos ? 0 : 1);
    }
    int status = 0;
    REQUIRE(waitpid(child, &status, 0) == child);
    REQUIRE(WIFEXITED(status));
    CHECK(WEXITSTATUS(status) == 0);
    const Content before = content_of(made.path());
    const Content after = content_of(dir.path());
    CHECK(after.samples.size() > 100);
    CHECK(after.samples.size() < before.samples.size());
    CHECK(std::equal(after.samples.begin(), after.samples.end(), before.samples.begin()));
}

TEST_CASE("a kill in the middle leaves a readable log") {
    const test::TempDir made;
    const test::TempDir dir;
    test::write_asl_folder(made, 600);
    const pid_t child = fork();
    REQUIRE(child >= 0);
    if (child == 0) {
        LinuxClock clock;
        Bench bench(made.path(), clock);
        RecordRun run(clock, bench.vehicle(), bench.sources(), dir.path(), LogForm::kFolder);
        run.start();
        clock.sleep(Duration::from_seconds(600.0));
        _exit(0);
    }
    LinuxClock clock;
    const std::string rows = dir.file("mav0/cam0/data.csv");
    std::error_code ignored;
    for (int i = 0; i < 600; ++i) {  // until a commit has left rows, the other tables' among them
        clock.sleep(Duration::from_seconds(0.05));
        if (std::filesystem::exists(rows, ignored) && std::filesystem::file_size(rows, ignored) > 2'000) {
            break;
        }
    }
    REQUIRE(kill(child, SIGKILL) == 0);
    int status = 0;
    REQUIRE(waitpid(child, &status, 0) == child);
    REQUIRE(WIFSIGNALED(status));
    const std::string last = test::read_file(rows);
    CHECK(last.ends_with(".png\n"));
    const Content after = content_of(dir.path());
    CHECK(after.pairs.size() > 10);
    const Content before = content_of(made.path());
    CHECK(std::equal(after.samples.begin(), after.samples.end(), before.samples.begin()));
}

}  // namespace
}  // namespace facet::record_run_test
