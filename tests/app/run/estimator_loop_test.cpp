// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/estimator_loop.h"

#include <catch2/catch.hpp>
#include <memory>
#include <vector>

#include "platform/port/clock.h"
#include "tests/support/asl_folder.h"
#include "tests/support/temp_dir.h"

namespace facet::estimator_loop_test {
namespace {

constexpr int kWidth = test::kAslWidth;
constexpr int kHeight = test::kAslHeight;

struct Collected final : LoopOutput {
    std::vector<Timestamp> estimates;
    std::vector<Timestamp> frames;
    std::vector<Status> statuses;
    std::vector<SyncFault> reports;
    std::vector<Timestamp> beliefs;
    void on_estimate(const FrameResult& frame, const Belief& belief, const Eigen::Vector3d&) override {
        CHECK(estimates.size() == frames.size());  // each frame is finished before the next one's estimate
        CHECK_FALSE(frame.has_mesh);
        estimates.push_back(frame.frame_stamp);
        beliefs.push_back(belief.stamp);
    }
    void on_frame(const FrameResult& frame, std::span<const DepartedFace>) override {
        frames.push_back(frame.frame_stamp);
        statuses.push_back(frame.status);
        CHECK(frames == estimates);
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
    explicit Bench(bool side_by_side) : is_double(side_by_side) {
        test::write_asl_folder(dir, 2);
        const Calibration calibration = load_euroc_calibration(dir.file("mav0"));
        ProgramConfig config;
        config.imu_noise = calibration.noise;
        pipeline.configure(config, calibration);
        options.sync.has_trigger = false;
        options.sync.votes = 1;
        options.side_by_side = side_by_side;
        pixels.assign(static_cast<std::size_t>(2 * kWidth * kHeight), 100);
    }
    void make() { loop = std::make_unique<EstimatorLoop>(options, clock, pipeline, *queues, output); }
    CameraFrame frame(std::int64_t ms, std::uint32_t sequence, SlotLender<8>& slots) const {
        const int width = is_double ? 2 * kWidth : kWidth;
        return {{ms * 1'000'000}, sequence, {pixels.data(), width, kHeight, width}, slots.take(), {}};
    }
    void image(std::int64_t ms, std::uint32_t sequence) {
        REQUIRE(ok(queues->left.push(frame(ms, sequence, left))));
        if (!is_double) {
            REQUIRE(ok(queues->right.push(frame(ms, sequence, right))));
        }
    }
    void imu(std::int64_t from_ms, std::int64_t to_ms) {
        for (std::int64_t ms = from_ms; ms <= to_ms; ms += 5) {
            REQUIRE(ok(queues->imu.push({{ms * 1'000'000}, Eigen::Vector3d::Zero(), {0.0, 0.0, 9.81}})));
        }
    }

    SlotLender<8> left;  ///< the slots of a camera, or of both side by side
    SlotLender<8> right;
    test::TempDir dir;
    SlowClock clock;
    bool is_double;
    FramePipeline pipeline;
    EstimatorLoopOptions options;
    std::unique_ptr<RunQueues> queues = std::make_unique<RunQueues>();
    Collected output;
    std::vector<std::uint8_t> pixels;
    std::unique_ptr<EstimatorLoop> loop;
};

TEST_CASE("a frame waits for the first inertial sample at or after its stamp, and gives both slots back") {
    const bool is_double = GENERATE(false, true);
    Bench bench(is_double);
    bench.make();
    bench.imu(0, 495);
    bench.image(497, 7);
    CHECK(bench.loop->step());
    CHECK(bench.output.frames.empty());
    CHECK(bench.left.lent() == 1);
    bench.imu(500, 500);
    (void)bench.loop->step();
    REQUIRE(bench.output.frames.size() == 1);
    CHECK(bench.output.frames[0] == Timestamp{497'000'000});
    CHECK(bench.output.statuses[0] == Status::kOk);
    CHECK(bench.output.beliefs[0] == Timestamp{497'000'000});
    CHECK(bench.pipeline.imu_samples() == 101);
    CHECK(bench.left.lent() == 0);
    CHECK(bench.right.lent() == 0);
    CHECK_FALSE(bench.loop->step());
}

TEST_CASE("when one of two cameras is silent, the other one's images reach the estimator alone") {
    const bool is_left = GENERATE(false, true);
    Bench bench(false);
    bench.make();
    bench.imu(0, 400);
    for (int k = 0; k < 20; ++k) {
        const std::int64_t ms = 400 + 50 * k;
        auto& queue = is_left ? bench.queues->left : bench.queues->right;
        SlotLender<8>& slots = is_left ? bench.left : bench.right;
        REQUIRE(ok(queue.push(bench.frame(ms, static_cast<std::uint32_t>(k), slots))));
        bench.imu(ms + 5, ms + 50);
        while (bench.loop->step()) {
        }
    }
    CHECK(bench.output.frames.size() >= (is_left ? 18 : 9));  // without a trigger the left one is the reference
    CHECK(bench.output.frames.back() == Timestamp{1'350'000'000});
    for (const Status status : bench.output.statuses) {
        CHECK(status == Status::kOk);
    }
    CHECK(bench.left.lent() == 0);
    CHECK(bench.right.lent() == 0);
}

TEST_CASE("of several frames that are ready only the newest is used") {
    Bench bench(true);
    bench.make();
    bench.imu(0, 1000);
    for (int k = 0; k < 3; ++k) {
        bench.image(500 + 50 * k, static_cast<std::uint32_t>(k));
    }
    while (bench.loop->step()) {
    }
    CHECK(bench.loop->counters().paired == 3);
    CHECK(bench.loop->counters().late == 2);
    REQUIRE(bench.output.frames.size() == 1);
    CHECK(bench.output.frames[0] == Timestamp{600'000'000});
    CHECK(bench.left.lent() == 0);
}

TEST_CASE("frames that take longer than a period are counted") {
    const bool slow = GENERATE(false, true);
    Bench bench(true);
    bench.clock.step = Duration::from_seconds(slow ? 0.06 : 0.04);
    bench.make();
    bench.imu(0, 700);
    for (int k = 0; k < 3; ++k) {
        bench.image(500 + 50 * k, static_cast<std::uint32_t>(k));
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
    bench.image(100'000, 0);
    (void)bench.loop->step();
    REQUIRE(bench.output.reports.size() == 2);  // both halves
    CHECK(bench.output.reports[0] == SyncFault::kEpochMismatch);
    CHECK(bench.loop->counters().findings[static_cast<std::size_t>(SyncFault::kEpochMismatch)] == 2);
    CHECK(bench.left.lent() == 0);
}

TEST_CASE("a camera that begins to count from zero again goes on") {
    Bench bench(true);
    bench.make();
    bench.imu(0, 400);
    for (int k = 0; k < 8; ++k) {
        const std::int64_t ms = 400 + 50 * k;
        bench.imu(ms + 5, ms + 50);
        bench.image(ms, static_cast<std::uint32_t>(k < 4 ? 20 + k : k - 4));
        while (bench.loop->step()) {
        }
        CHECK(bench.left.lent() == 0);
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

TEST_CASE("samples that have come with a frame are not given to the estimator before the next one needs them") {
    Bench bench(true);
    bench.make();
    bench.imu(0, 540);
    bench.image(500, 0);
    while (bench.loop->step()) {
    }
    REQUIRE(bench.output.frames.size() == 1);
    CHECK(bench.pipeline.imu_samples() == 101);
}

TEST_CASE("a camera whose stamps are off the IMU's clock waits for the samples that its shift asks for") {
    Bench bench(true);
    bench.options.camera_time_shift = Duration::from_seconds(0.03);
    bench.make();
    bench.imu(0, 525);
    bench.image(500, 0);
    while (bench.loop->step()) {
    }
    CHECK(bench.output.frames.empty());
    bench.imu(530, 530);
    (void)bench.loop->step();
    REQUIRE(bench.output.frames.size() == 1);
    CHECK(bench.output.frames[0] == Timestamp{530'000'000});
}

TEST_CASE("at the end frames that are covered are used, and what is left goes with the loop") {
    Bench bench(true);
    bench.make();
    bench.imu(0, 505);
    bench.image(500, 0);
    bench.image(550, 1);  // not covered
    bench.loop->finish();
    REQUIRE(bench.output.frames.size() == 1);
    CHECK(bench.output.frames[0] == Timestamp{500'000'000});
    CHECK(bench.left.lent() == 1);  // the one that is not covered stays in the synchroniser
    bench.loop.reset();
    CHECK(bench.left.lent() == 0);
}

}  // namespace
}  // namespace facet::estimator_loop_test
