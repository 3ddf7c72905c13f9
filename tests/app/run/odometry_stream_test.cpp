// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/odometry_stream.h"

#include <catch2/catch.hpp>
#include <memory>
#include <vector>

#include "app/pipeline/to_odometry.h"
#include "tests/support/allocation_guard.h"

namespace facet::odometry_stream_test {
namespace {

constexpr std::int64_t kImuStep_ns = 5'000'000;
constexpr double kSpeed = 2.0;  // m/s, along x

ImuSample sample_at(std::int64_t ns) { return {{ns}, {0.0, 0.0, 0.1}, {0.0, 0.0, 9.81}}; }

/// A frame that sees the body fly along x without turning; its gyroscope reads 0.1 rad/s too much about z.
FrameOutcome frame_at(std::int64_t ns, TrackingState state = TrackingState::kTracking) {
    FrameOutcome outcome;
    outcome.frame_stamp = outcome.estimate.stamp = outcome.belief.stamp = {ns};
    outcome.belief.state.p_W_B.x() = kSpeed * static_cast<double>(ns) * 1e-9;
    outcome.belief.state.v_W_B.x() = kSpeed;
    outcome.belief.state.bias.gyro.z() = 0.1;
    outcome.belief.covariance = 1e-4 * StateCovariance::Identity();
    outcome.estimate.state = outcome.belief.state;
    outcome.estimate.covariance = outcome.belief.covariance.topLeftCorner<9, 9>();
    outcome.estimate.health.state = state;
    outcome.estimate.health.quality = state == TrackingState::kLost ? 0 : 80;
    return outcome;
}

struct Bench {
    explicit Bench(double rate_hz, double smoothing_s = 0.0)
        : stream(std::make_unique<OdometryStream>(ProgramConfig{}, VehicleOdometry{rate_hz, smoothing_s, {}})) {}
    void imu(std::int64_t from_ms, std::int64_t to_ms) {
        for (std::int64_t ns = from_ms * 1'000'000; ns <= to_ms * 1'000'000; ns += kImuStep_ns) {
            if (Odometry odometry; stream->add_imu(sample_at(ns), odometry)) {
                sent.push_back(odometry);
            }
        }
    }
    void frame(const FrameOutcome& outcome) {
        if (Odometry odometry; stream->add_frame(outcome, odometry)) {
            sent.push_back(odometry);
        }
    }
    std::unique_ptr<OdometryStream> stream;
    std::vector<Odometry> sent;
};

TEST_CASE("the transform to the map is that of the newest frame, at the frames' rate and at the sensor's") {
    for (const double rate_hz : {0.0, 200.0}) {
        Bench bench(rate_hz);
        bench.imu(0, 50);
        bench.frame(frame_at(50'000'000));
        bench.imu(55, 100);
        FrameOutcome outcome = frame_at(100'000'000);
        outcome.T_M_W = YawPose{0.5, {1.0, 2.0, 3.0}};
        bench.frame(outcome);
        bench.imu(105, 150);
        REQUIRE(bench.sent.size() > 1);
        CHECK(!bench.sent.front().is_in_map);
        CHECK(bench.sent.back().is_in_map);
        CHECK(bench.sent.back().map_yaw == 0.5);
        CHECK(bench.sent.back().map_p == Eigen::Vector3d(1.0, 2.0, 3.0));
        outcome = frame_at(150'000'000);
        bench.frame(outcome);
        bench.imu(155, 200);
        CHECK(!bench.sent.back().is_in_map);
    }
}

TEST_CASE("odometry has the consumer's order of the covariance, rates without bias, and quality") {
    Estimate estimate;
    for (int i = 0; i < 9; ++i) {
        for (int j = 0; j < 9; ++j) {
            estimate.covariance(i, j) = 10 * i + j;
        }
    }
    estimate.state.bias.gyro = {0.1, 0.0, 0.0};
    estimate.health.state = TrackingState::kTracking;
    estimate.health.quality = 70;
    estimate.health.reset_counter = 258;
    ImuNoise noise;
    noise.gyro_noise_rad_per_s_per_sqrt_hz = 1e-3;
    noise.rate_hz = 200.0;
    const Odometry o = to_odometry(estimate, {0.3, 0.2, 0.1}, noise);
    CHECK(o.pose_covariance(0, 0) == 33.0);  // p p
    CHECK(o.pose_covariance(0, 3) == 30.0);  // p theta
    CHECK(o.pose_covariance(4, 1) == 14.0);  // theta p
    CHECK(o.pose_covariance(5, 5) == 22.0);  // theta theta
    CHECK(o.v_covariance(1, 2) == 78.0);
    CHECK(o.w_B.x() == Approx(0.2));
    CHECK(o.w_covariance(2, 2) == Approx(2e-4));
    CHECK(o.quality == 70);
    CHECK(o.reset_counter == 2);
    estimate.health.state = TrackingState::kLost;
    CHECK(to_odometry(estimate, {0, 0, 0}, noise).quality == -1);
}

TEST_CASE("poses come at the rate asked for, up to the IMU's, on time and never backwards") {
    const double rate_hz = GENERATE(30.0, 50.0, 100.0, 200.0, 1000.0);
    Bench bench(rate_hz);
    bench.imu(0, 0);
    for (int k = 1; k <= 40; ++k) {  // frames at 20 Hz, each 35 ms late
        bench.imu(50 * k - 45, 50 * k - 15);
        bench.frame(frame_at((50 * k - 50) * 1'000'000LL));
        bench.imu(50 * k - 10, 50 * k);
    }
    const double imu_hz = 1e9 / kImuStep_ns;
    const double expected_hz = std::min(rate_hz, imu_hz);
    CHECK(static_cast<double>(bench.sent.size()) == Approx(expected_hz * (2.0 - 0.035)).margin(1.5));
    CHECK(bench.sent.front().stamp == Timestamp{40'000'000});  // right after the first frame
    CHECK(bench.sent.back().stamp.ns >= 2'000'000'000 - static_cast<std::int64_t>(1e9 / expected_hz) - kImuStep_ns / 2);
    for (std::size_t i = 1; i < bench.sent.size(); ++i) {
        const double step_s = (bench.sent[i].stamp - bench.sent[i - 1].stamp).seconds();
        REQUIRE(step_s > 0.0);
        REQUIRE(step_s < 1.0 / expected_hz + 0.51 / imu_hz);
    }
}

TEST_CASE("a pose is the newest frame's state carried on to the sample, its rate without bias") {
    Bench bench(200.0);
    bench.imu(0, 100);
    CHECK(bench.sent.empty());  // no start yet
    bench.frame(frame_at(50'000'000));
    bench.imu(105, 105);
    REQUIRE(bench.sent.size() == 1);
    const Odometry& o = bench.sent[0];
    CHECK(o.stamp == Timestamp{105'000'000});
    CHECK(o.p_W_B.x() == Approx(kSpeed * 0.105));
    CHECK(o.v_W_B.x() == Approx(kSpeed));
    CHECK(o.q_W_B.angularDistance(Eigen::Quaterniond::Identity()) < 1e-9);
    CHECK(std::abs(o.w_B.z()) < 1e-12);
    CHECK(o.quality == 80);
    CHECK(o.pose_covariance(0, 0) > 1e-4);  // grows with the velocity's
    CHECK(o.pose_covariance(0, 0) < 1.1e-4);
}

TEST_CASE("the covariance carried on includes what position and yaw had when the window began") {
    Bench bench(200.0);
    bench.imu(0, 50);
    FrameOutcome outcome = frame_at(50'000'000);
    outcome.estimate.covariance(3, 3) += 0.25;
    bench.frame(outcome);
    bench.imu(55, 55);
    REQUIRE(bench.sent.size() == 1);
    CHECK(bench.sent[0].pose_covariance(0, 0) == Approx(0.2501).epsilon(1e-3));
}

TEST_CASE("being lost goes on as quality -1, a refused frame degrades, a new start is silence") {
    Bench bench(200.0);
    bench.imu(0, 50);
    bench.frame(frame_at(50'000'000));
    FrameOutcome refused = frame_at(0, TrackingState::kDegraded);
    refused.status = Status::kInvalidArgument;
    refused.belief.state.p_W_B.x() = 99.0;
    refused.estimate.health.quality = 40;
    bench.frame(refused);
    bench.imu(55, 55);
    REQUIRE(bench.sent.size() == 1);
    CHECK(bench.sent.back().quality == 40);
    CHECK(bench.sent.back().p_W_B.x() == Approx(kSpeed * 0.055));

    FrameOutcome lost = frame_at(55'000'000, TrackingState::kLost);
    lost.belief.state.v_W_B.setConstant(std::nan(""));
    bench.frame(lost);
    bench.imu(60, 60);
    REQUIRE(bench.sent.size() == 2);
    CHECK(bench.sent.back().quality == -1);
    CHECK(bench.sent.back().p_W_B.x() == Approx(kSpeed * 0.06));  // of the last finite belief

    bench.frame(frame_at(60'000'000, TrackingState::kInit));
    bench.imu(65, 70);
    CHECK(bench.sent.size() == 2);
    bench.frame(frame_at(70'000'000));
    bench.imu(75, 75);
    CHECK(bench.sent.size() == 3);
}

TEST_CASE("corrections are smoothed if that is asked for, resets are not") {
    const bool is_reset = GENERATE(false, true);
    Bench bench(200.0, 0.1);
    bench.imu(0, 50);
    bench.frame(frame_at(50'000'000));
    bench.imu(55, 100);
    FrameOutcome moved = frame_at(100'000'000);
    moved.belief.state.p_W_B.y() = 1.0;
    moved.estimate.health.reset_counter = is_reset ? 1 : 0;
    bench.frame(moved);
    bench.imu(105, 105);
    const double y = bench.sent.back().p_W_B.y();
    CHECK(y == Approx(is_reset ? 1.0 : 1.0 - std::exp(-0.05)));
    CHECK(bench.sent.back().reset_counter == (is_reset ? 1 : 0));
}

TEST_CASE("at rate 0 there is a pose a frame, at its exposure") {
    Bench bench(0.0);
    bench.imu(0, 100);
    bench.frame(frame_at(40'000'000, TrackingState::kInit));
    CHECK(bench.sent.empty());
    bench.frame(frame_at(50'000'000));
    bench.frame(frame_at(100'000'000, TrackingState::kLost));
    REQUIRE(bench.sent.size() == 2);
    CHECK(bench.sent[0].stamp == Timestamp{50'000'000});
    CHECK(bench.sent[1].quality == -1);
}

TEST_CASE("carrying on and sending use no heap") {
    Bench bench(200.0);
    bench.imu(0, 50);
    Odometry odometry;
    const FrameOutcome outcome = frame_at(50'000'000);
    test::AllocationGuard guard;
    (void)bench.stream->add_frame(outcome, odometry);
    (void)bench.stream->add_imu(sample_at(55'000'000), odometry);
    CHECK(guard.allocations() == 0);
    CHECK(odometry.stamp == Timestamp{55'000'000});
}

TEST_CASE("the angular rate is that of an ideal IMU, its bias taken off") {
    ProgramConfig config;
    config.imu_model =
        ImuModel(Eigen::Matrix3d::Identity(), 2.0 * Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Zero());
    const auto stream = std::make_unique<OdometryStream>(config, VehicleOdometry{200.0, 0.0, {}});
    Odometry odometry;
    FrameOutcome outcome = frame_at(0);
    stream->add_imu(sample_at(0), odometry);
    stream->add_frame(outcome, odometry);
    REQUIRE(stream->add_imu(sample_at(kImuStep_ns), odometry));
    CHECK(odometry.w_B.z() == Approx(0.05 - 0.1));  // reads 0.1, which is 0.05
}

}  // namespace
}  // namespace facet::odometry_stream_test
