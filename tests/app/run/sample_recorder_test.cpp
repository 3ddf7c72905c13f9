// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/sample_recorder.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <csignal>
#include <thread>
#include <vector>

#include "drivers/replay_asl/asl_dataset.h"
#include "platform/linux/linux_clock.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/scripted_source.h"
#include "tests/support/temp_dir.h"

namespace facet {
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

/// What is in a log; bad: rows that are not whole or lack their image. The last pair may lack its right row.
struct LogContent {
    explicit LogContent(const std::string& folder) {
        AslDataset log;
        std::string error;
        const AslWarningSink sink = [&](const AslWarning& warning) {
            const AslWarningKind kind = warning.kind;
            bad += kind == AslWarningKind::kMalformedRow || kind == AslWarningKind::kMissingFile ||
                           kind == AslWarningKind::kCorruptImage || kind == AslWarningKind::kWrongSize
                       ? 1
                       : 0;
        };
        REQUIRE(ok(log.open(folder, {}, sink, error)));
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

TEST_CASE("a disc that makes everything wait costs samples, which are counted, and never the estimator") {
    const test::TempDir dir;
    const ManualClock clock;
    const auto recorder = std::make_unique<SampleRecorder>(clock, dir.path(), true, kPixels);
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
    const test::TempDir dir;
    const ManualClock clock;
    SampleRecorder recorder(clock, dir.path(), true, kPixels);
    BothViews views;
    SyncedFrame pair = views.at({1'000'000'000});
    pair.right.image = {views.pixels.data(), 2 * kWidth, kHeight, 2 * kWidth};
    recorder.on_pair(pair);
    recorder.write(true);
    CHECK(std::filesystem::exists(dir.file("mav0/cam0/data/1000000000.png")));
    CHECK_FALSE(std::filesystem::exists(dir.file("mav0/cam1/data/1000000000.png")));
}

/// Records 20 pairs and 200 samples a second, stamped with the time, until it is killed.
[[noreturn]] void record_for_ever(const std::string& folder) {
    LinuxClock clock;
    SampleRecorder recorder(clock, folder, true, kPixels);
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
    const test::TempDir dir;
    const pid_t child = fork();
    REQUIRE(child >= 0);
    if (child == 0) {
        record_for_ever(dir.path());
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

TEST_CASE("when the disc is full, what there is stays readable, and the rest is counted") {
    const test::TempDir dir;
    ManualClock clock({1'000'000'000});
    SampleRecorder recorder(clock, dir.path(), true, kPixels);
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
    const rlimit limit{std::filesystem::file_size(dir.file("mav0/imu0/data.csv")) + 500, before.rlim_max};
    REQUIRE(setrlimit(RLIMIT_FSIZE, &limit) == 0);
    second(2'000'000'000);
    (void)setrlimit(RLIMIT_FSIZE, &before);
    (void)std::signal(SIGXFSZ, handler);
    CHECK(recorder.failure().find("cannot be written") != std::string::npos);
    const LogContent log(dir.path());
    CHECK(log.bad == 0);
    CHECK(log.pairs >= 20);
    CHECK(log.samples > 200);
    CHECK(log.samples < 400);
    const std::uint64_t written = recorder.counters().pairs;
    second(3'000'000'000);
    CHECK(recorder.counters().pairs == written);
    CHECK(recorder.counters().samples_dropped >= 200);
}

}  // namespace
}  // namespace facet
