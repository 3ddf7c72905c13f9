// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/estimator_loop.h"

#include <catch2/catch.hpp>
#include <memory>
#include <set>
#include <vector>

#include "platform/port/clock.h"
#include "tests/support/asl_folder.h"
#include "tests/support/temp_dir.h"

namespace facet {
namespace {

constexpr int kWidth = test::kAslWidth;
constexpr int kHeight = test::kAslHeight;

/// A camera of which only the slots are of interest.
class SlotCamera final : public CameraSource {
public:
    std::set<int> out;
    Status start() override { return Status::kOk; }
    void stop() override {}
    ClockDomain clock() const override { return ClockDomain::kMonotonic; }
    SourceCounters counters() const override { return {}; }
    std::string_view problem() const override { return ""; }
    Status next(Duration, CameraFrame&) override { return Status::kNotReady; }
    void release(int slot) override { CHECK(out.erase(slot) == 1); }
};

struct Collected final : LoopOutput {
    std::vector<Timestamp> frames;
    std::vector<Status> statuses;
    std::vector<SyncFault> reports;
    void on_frame(const FrameResult& frame, std::span<const DepartedFace>, const Eigen::Vector3d&) override {
        frames.push_back(frame.frame_stamp);
        statuses.push_back(frame.status);
    }
    void on_report(const SyncReport& report) override { reports.push_back(report.fault); }
};

/// A clock that goes on by a step whenever it is read.
class SlowClock final : public Clock {
public:
    Duration step;
    Timestamp now() const override { return now_ = now_ + step; }
    ClockPair read_pair() const override { return {now_, now_, {}}; }
    void sleep_until(Timestamp) override {}

private:
    mutable Timestamp now_;
};

/// A loop on grey images, with time in milliseconds.
struct Bench {
    explicit Bench(bool side_by_side, bool lossless = false) : is_double(side_by_side) {
        test::write_asl_folder(dir, 2);
        const Calibration calibration = load_euroc_calibration(dir.file("mav0"));
        ProgramConfig config;
        config.imu_noise = calibration.noise;
        pipeline.configure(config, calibration);
        options.sync.has_trigger = false;
        options.sync.votes = 1;
        options.side_by_side = side_by_side;
        options.lossless = lossless;
        pixels.assign(static_cast<std::size_t>(2 * kWidth * kHeight), 100);
    }
    void make() {
        loop = std::make_unique<EstimatorLoop>(options, clock, pipeline, *queues, left, is_double ? nullptr : &right,
                                               output);
    }
    CameraFrame frame(std::int64_t ms, std::uint32_t sequence, int slot) const {
        const int width = is_double ? 2 * kWidth : kWidth;
        return {{ms * 1'000'000}, sequence, {pixels.data(), width, kHeight, width}, slot, {}};
    }
    void image(std::int64_t ms, std::uint32_t sequence, int slot) {
        left.out.insert(slot);
        REQUIRE(ok(queues->left.push(frame(ms, sequence, slot))));
        if (!is_double) {
            right.out.insert(slot);
            REQUIRE(ok(queues->right.push(frame(ms, sequence, slot))));
        }
    }
    void imu(std::int64_t from_ms, std::int64_t to_ms) {
        for (std::int64_t ms = from_ms; ms <= to_ms; ms += 5) {
            REQUIRE(ok(queues->imu.push({{ms * 1'000'000}, Eigen::Vector3d::Zero(), {0.0, 0.0, 9.81}})));
        }
    }

    test::TempDir dir;
    SlowClock clock;
    bool is_double;
    FramePipeline pipeline;
    EstimatorLoopOptions options;
    std::unique_ptr<RunQueues> queues = std::make_unique<RunQueues>();
    SlotCamera left;
    SlotCamera right;
    Collected output;
    std::vector<std::uint8_t> pixels;
    std::unique_ptr<EstimatorLoop> loop;
};

TEST_CASE("a frame waits for inertial samples beyond its stamp, and gives both slots back") {
    const bool is_double = GENERATE(false, true);
    Bench bench(is_double);
    bench.make();
    bench.imu(0, 500);
    bench.image(500, 7, 2);
    CHECK(bench.loop->step());
    CHECK(bench.output.frames.empty());
    CHECK(bench.left.out.size() == 1);
    bench.imu(505, 515);
    (void)bench.loop->step();
    CHECK(bench.output.frames.empty());
    bench.imu(520, 520);
    (void)bench.loop->step();
    REQUIRE(bench.output.frames.size() == 1);
    CHECK(bench.output.frames[0] == Timestamp{500'000'000});
    CHECK(bench.output.statuses[0] == Status::kOk);
    CHECK(bench.left.out.empty());
    CHECK(bench.right.out.empty());
    CHECK_FALSE(bench.loop->step());
}

TEST_CASE("of several frames that are ready only the newest is used, of a log every one") {
    const bool lossless = GENERATE(false, true);
    Bench bench(true, lossless);
    bench.make();
    bench.imu(0, 1000);
    for (int k = 0; k < 3; ++k) {
        bench.image(500 + 50 * k, static_cast<std::uint32_t>(k), k);
    }
    while (bench.loop->step()) {
    }
    CHECK(bench.loop->counters().paired == 3);
    if (lossless) {
        CHECK(bench.output.frames.size() == 3);
        CHECK(bench.loop->counters().late == 0);
        CHECK(bench.queues->imu.size() > 0);  // nothing waits for them
    } else {
        REQUIRE(bench.output.frames.size() == 1);
        CHECK(bench.output.frames[0] == Timestamp{600'000'000});
        CHECK(bench.loop->counters().late == 2);
    }
    CHECK(bench.left.out.empty());
}

TEST_CASE("frames that take longer than a period are counted") {
    const bool slow = GENERATE(false, true);
    Bench bench(true);
    bench.clock.step = Duration::from_seconds(slow ? 0.06 : 0.04);
    bench.make();
    bench.imu(0, 700);
    for (int k = 0; k < 3; ++k) {
        bench.image(500 + 50 * k, static_cast<std::uint32_t>(k), 0);
        (void)bench.loop->step();
    }
    CHECK(bench.output.frames.size() == 3);
    CHECK(bench.loop->counters().overruns == (slow ? 3 : 0));
}

TEST_CASE("images of another epoch are refused by name and their slots given back") {
    Bench bench(true);
    bench.make();
    bench.imu(0, 300);
    (void)bench.loop->step();
    bench.image(100'000, 0, 0);
    (void)bench.loop->step();
    REQUIRE(bench.output.reports.size() == 2);  // both halves
    CHECK(bench.output.reports[0] == SyncFault::kEpochMismatch);
    CHECK(bench.loop->counters().findings[static_cast<std::size_t>(SyncFault::kEpochMismatch)] == 2);
    CHECK(bench.left.out.empty());
}

TEST_CASE("a camera that begins to count from zero again goes on") {
    Bench bench(true);
    bench.make();
    bench.imu(0, 400);
    for (int k = 0; k < 8; ++k) {
        const std::int64_t ms = 400 + 50 * k;
        bench.imu(ms + 5, ms + 50);
        bench.image(ms, static_cast<std::uint32_t>(k < 4 ? 20 + k : k - 4), 0);
        while (bench.loop->step()) {
        }
        CHECK(bench.left.out.empty());
    }
    CHECK(bench.output.frames.size() == 8);
    CHECK(bench.loop->counters().findings[static_cast<std::size_t>(SyncFault::kMissingRight)] == 0);
}

TEST_CASE("inertial samples do not wait for frames that never come") {
    Bench bench(true);
    bench.options.max_hold = Duration::from_seconds(0.1);
    bench.make();
    bench.imu(0, 1000);
    (void)bench.loop->step();
    CHECK(bench.pipeline.imu_samples() == 180);  // up to 0.1 s before the newest
}

TEST_CASE("at the end frames are used without the delay, and what is left is released") {
    Bench bench(true);
    bench.make();
    bench.imu(0, 505);
    bench.image(500, 0, 0);
    bench.image(550, 1, 1);  // not covered
    (void)bench.loop->step();
    CHECK(bench.output.frames.empty());
    bench.left.out.erase(1);  // stays in the synchroniser, with the camera that is stopped next
    bench.loop->finish();
    REQUIRE(bench.output.frames.size() == 1);
    CHECK(bench.output.frames[0] == Timestamp{500'000'000});
    CHECK(bench.left.out.empty());
}

}  // namespace
}  // namespace facet
