// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/sample_recorder.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <map>
#include <thread>
#include <vector>

#include "app/lab/convert/mcap_log.h"
#include "app/lab/convert/opened_log.h"
#include "app/lab/convert/unpack_log.h"
#include "app/output/asl_log.h"
#include "app/output/mcap_sample_log.h"
#include "app/run/flight_log.h"
#include "drivers/replay_asl/asl_dataset.h"
#include "platform/linux/linux_clock.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/scripted_source.h"
#include "tests/support/temp_dir.h"

namespace facet::sample_recorder_test {
namespace {

constexpr int kWidth = 96;
constexpr int kHeight = 64;
constexpr std::size_t kPixels = static_cast<std::size_t>(kWidth) * kHeight;

/// A side-by-side image, as an estimator loop hands it on.
struct BothViews {
    SyncedFrame at(Timestamp stamp) {
        for (std::size_t i = 0; i < pixels.size(); ++i) {
            pixels[i] = static_cast<std::uint8_t>(i * 31 + static_cast<std::size_t>(stamp.ns / 50'000'000));
        }
        SyncedFrame pair;
        pair.stamp = pair.left.stamp = pair.right.stamp = stamp;
        pair.left.image = {pixels.data(), kWidth, kHeight, 2 * kWidth};
        pair.right.image = {pixels.data() + kWidth, kWidth, kHeight, 2 * kWidth};
        return pair;
    }
    std::vector<std::uint8_t> pixels = std::vector<std::uint8_t>(2 * kPixels);
};

ImuSample rest_at(Timestamp stamp) { return {stamp, Eigen::Vector3d::Zero(), {0.0, 0.0, 9.81}}; }

std::unique_ptr<SampleLog> make_log(const std::string& folder, LogForm form) {
    return form == LogForm::kMcap ? std::unique_ptr<SampleLog>(std::make_unique<McapSampleLog>(folder, true))
                                  : std::make_unique<AslLog>(folder, true);
}

/// What is in a log; bad: rows that are not whole or lack their image. The last pair may lack its right row.
struct LogContent {
    explicit LogContent(const std::string& folder) {
        const bool is_file = std::filesystem::exists(folder + "/flight.mcap");
        const std::string path = is_file ? folder + "/flight.mcap" : folder;
        const OpenedLog opened(
            path, [this](const std::string& line) { bad += line.find("was cut off") == std::string::npos ? 1 : 0; });
        AslDataset log;
        AslOptions options;
        options.files = opened.files();
        std::string error;
        const AslWarningSink sink = [&](const AslWarning& warning) {
            const AslWarningKind kind = warning.kind;
            bad += kind == AslWarningKind::kMalformedRow || kind == AslWarningKind::kMissingFile ||
                           kind == AslWarningKind::kCorruptImage || kind == AslWarningKind::kWrongSize
                       ? 1
                       : 0;
        };
        REQUIRE(ok(log.open(path, options, sink, error)));
        ImuSample sample;
        StereoFrame frame;
        for (auto event = log.next(sample, frame); event != AslDataset::Event::kEnd; event = log.next(sample, frame)) {
            if (event == AslDataset::Event::kImu) {
                ++samples;
                last_sample = sample.stamp;
            } else {
                ++pairs;
                last_pair = frame.stamp;
            }
        }
    }
    int samples = 0;
    int pairs = 0;
    int bad = 0;
    Timestamp last_sample;
    Timestamp last_pair;
};

TEST_CASE("a disk that makes everything wait costs samples, which are counted, and never the estimator") {
    const test::TempDir dir;
    const ManualClock clock;
    const auto recorder = std::make_unique<SampleRecorder>(clock, make_log(dir.path(), LogForm::kFolder), kPixels);
    BothViews views;
    const test::AllocationGuard guard;
    for (int k = 0; k < 9000; ++k) {
        recorder->on_imu(rest_at({1'000'000'000 + k * 1'000'000LL}));
    }
    for (int k = 0; k < 40; ++k) {
        recorder->on_pair(views.at({1'000'000'000 + k * 50'000'000LL}));
    }
    for (std::uint32_t k = 0; k < 600; ++k) {
        recorder->on_edge({{1'000'000'000 + k * 1'000LL}, k, true});
    }
    const std::uint64_t allocations = guard.allocations();
    CHECK(allocations == 0);
    CHECK(recorder->counters().pairs_dropped == 8);
    CHECK(recorder->counters().samples_dropped == 808 + 88);
    recorder->write(true);
    CHECK(recorder->failure().empty());
    CHECK(recorder->counters().pairs == 32);
    const LogContent log(dir.path());
    const std::string rows = test::read_file(dir.file("mav0/imu0/data.csv"));
    CHECK(std::count(rows.begin(), rows.end(), '\n') == 8192 + 1);
    CHECK(log.pairs == 32);
    CHECK(log.bad == 0);
    recorder->on_pair(views.at({3'000'000'000}));  // the buffers are free again
    CHECK(recorder->counters().pairs_dropped == 8);
}

TEST_CASE("an image of another size is left out, the other one is kept") {
    constexpr LogForm form = LogForm::kFolder;
    const test::TempDir dir;
    const ManualClock clock;
    SampleRecorder recorder(clock, make_log(dir.path(), form), kPixels);
    BothViews views;
    SyncedFrame pair = views.at({1'000'000'000});
    pair.right.image = {views.pixels.data(), 2 * kWidth, kHeight, 2 * kWidth};
    recorder.on_pair(pair);
    recorder.write(true);
    CHECK(std::filesystem::exists(dir.file("mav0/cam0/data/1000000000.png")));
    CHECK_FALSE(std::filesystem::exists(dir.file("mav0/cam1/data/1000000000.png")));
}

/// Records 20 pairs and 200 samples a second, stamped with the time, until it is killed.
[[noreturn]] void record_for_ever(const std::string& folder, LogForm form) {
    LinuxClock clock;
    SampleRecorder recorder(clock, make_log(folder, form), kPixels);
    const std::atomic<bool> stopping{false};
    std::thread writer([&] { recorder.write(stopping); });
    BothViews views;
    for (int k = 0;; ++k) {
        if (k % 10 == 5) {
            recorder.on_pair(views.at(clock.now()));
        }
        recorder.on_imu(rest_at(clock.now()));
        clock.sleep(Duration::from_seconds(0.005));
    }
}

TEST_CASE("a program that is killed leaves a readable log that lacks at most the last second") {
    const LogForm form = GENERATE(LogForm::kFolder, LogForm::kMcap);
    const test::TempDir dir;
    const pid_t child = fork();
    REQUIRE(child >= 0);
    if (child == 0) {
        record_for_ever(dir.path(), form);
    }
    LinuxClock clock;
    clock.sleep(Duration::from_seconds(2.8));
    REQUIRE(kill(child, SIGKILL) == 0);
    const Timestamp killed = clock.now();
    int status = 0;
    REQUIRE(waitpid(child, &status, 0) == child);
    REQUIRE(WIFSIGNALED(status));
    const LogContent log(dir.path());
    CHECK(log.bad == 0);
    CHECK(log.pairs > 20);
    CHECK((killed - log.last_sample).seconds() < 1.0);
    CHECK((killed - log.last_pair).seconds() < 1.0);
}

TEST_CASE("when the disk is full, what there is stays readable, and the rest is counted") {
    const LogForm form = GENERATE(LogForm::kFolder, LogForm::kMcap);
    const test::TempDir dir;
    ManualClock clock({1'000'000'000});
    SampleRecorder recorder(clock, make_log(dir.path(), form), kPixels);
    BothViews views;
    const auto second = [&](std::int64_t begin_ns) {
        for (int k = 0; k < 200; ++k) {
            recorder.on_imu(rest_at({begin_ns + k * 5'000'000LL}));
            if (k % 10 == 5) {
                recorder.on_pair(views.at({begin_ns + k * 5'000'000LL}));
            }
        }
        recorder.write(true);
    };
    second(1'000'000'000);
    REQUIRE(recorder.failure().empty());
    // No file can grow any more: what a full disc does, in the middle of a line.
    rlimit before{};
    REQUIRE(getrlimit(RLIMIT_FSIZE, &before) == 0);
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    const bool is_file = form == LogForm::kMcap;
    const std::string grown = dir.file(is_file ? "flight.mcap" : "mav0/imu0/data.csv");
    const rlimit limit{std::filesystem::file_size(grown) + 500, before.rlim_max};
    REQUIRE(setrlimit(RLIMIT_FSIZE, &limit) == 0);
    second(2'000'000'000);
    (void)setrlimit(RLIMIT_FSIZE, &before);
    (void)std::signal(SIGXFSZ, handler);
    CHECK(recorder.failure().find("cannot be written") != std::string::npos);
    const LogContent log(dir.path());
    CHECK(log.bad == 0);
    CHECK(log.pairs >= 20);
    CHECK(log.samples > (is_file ? 190 : 200));  // a file keeps what came before the commit that failed
    CHECK(log.samples < 400);
    const std::uint64_t written = recorder.counters().pairs;
    second(3'000'000'000);
    CHECK(recorder.counters().pairs == written);
    CHECK(recorder.counters().samples_dropped >= 200);
}

/// Every file of a folder with its content.
std::map<std::string, std::string> files_in(const std::string& folder) {
    std::map<std::string, std::string> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
        if (entry.is_regular_file()) {
            const std::string path = entry.path().string();
            files[path.substr(folder.size())] = test::read_file(path);
        }
    }
    return files;
}

TEST_CASE("an MCAP file becomes the folder that the same samples would have become") {
    const test::TempDir dir;
    for (const LogForm form : {LogForm::kFolder, LogForm::kMcap}) {
        ManualClock clock({1'000'000'000});
        SampleRecorder recorder(clock, make_log(dir.path(), form), kPixels);
        BothViews views;
        for (int k = 0; k < 20; ++k) {
            const Timestamp stamp{1'000'000'000 + k * 50'000'000LL};
            SyncedFrame pair = views.at(stamp);
            pair.left.sequence = static_cast<std::uint32_t>(3 * k);
            pair.left.exposure = Duration{4'000'123};
            pair.right.image = k % 5 == 3 ? ImageView{} : pair.right.image;
            recorder.on_edge({stamp - Duration{1'000}, static_cast<std::uint32_t>(k), k % 2 == 0});
            recorder.on_imu({stamp, {1e-300 * k, -1.0 / (k + 1), 12345678.9}, {0.1 * k, -0.0, 9.81}});
            recorder.on_pair(pair);
        }
        // What is no number is in both as such.
        recorder.on_imu({{2'000'000'000}, {std::nan(""), 0.0, 0.0}, {0.0, 0.0, 9.81}});
        recorder.write(true);
        recorder.finish();
        REQUIRE(recorder.failure().empty());
    }
    McapLog log(dir.file("flight.mcap"), [](const std::string& line) { FAIL(line); });
    CHECK(log.file().is_whole());
    (void)unpack_log(
        log, dir.file("again"), [](std::uint64_t) {}, false);
    const auto again = files_in(dir.file("again/mav0"));
    const auto folder = files_in(dir.file("mav0"));
    REQUIRE(folder.size() == 20 + 16 + 5);
    CHECK(again.size() == folder.size());
    for (const auto& [name, content] : folder) {
        INFO(name);
        CHECK(again.contains(name));
        CHECK((again.contains(name) ? again.at(name) : "") == content);
    }
}

TEST_CASE("no log is ever overwritten") {
    const test::TempDir dir;
    const LogForm form = GENERATE(LogForm::kFolder, LogForm::kMcap);
    (void)make_log(dir.path(), form);
    CHECK_THROWS_WITH(make_log(dir.path(), form), Catch::Contains("there is a log already"));
}

}  // namespace
}  // namespace facet::sample_recorder_test
