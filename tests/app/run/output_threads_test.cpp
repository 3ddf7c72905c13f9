// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/output_threads.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <thread>

#include "tests/support/scripted_source.h"
#include "tests/support/temp_dir.h"

namespace facet {
namespace {

FrameResult frame_in(TrackingState state, int k) {
    FrameResult frame;
    frame.frame_stamp = frame.output_stamp = {1'000'000'000 + k * 50'000'000LL};
    frame.estimate.stamp = frame.frame_stamp;
    frame.estimate.health.state = state;
    frame.estimate.health.quality = 70;
    frame.is_usable = is_usable(state);
    return frame;
}

class RecordingSink final : public OdometrySink {
public:
    Status answer = Status::kOk;
    std::vector<Odometry> sent;
    Status send(const Odometry& odometry) override {
        sent.push_back(odometry);
        return answer;
    }
};

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

TEST_CASE("poses reach the sinks and frames the files, however early the stop comes") {
    const test::TempDir dir;
    const ManualClock clock({3'000'000'000});
    FrameRecorder recorder(dir.path());
    recorder.open();
    RecordingSink sink;
    EventQueue events;
    auto output = std::make_unique<OutputThreads>(clock, ImuNoise{}, std::vector<OdometrySink*>{&sink}, recorder,
                                                  std::vector<EventQueue*>{&events}, 3);
    (void)events.push(RunEvent::make("source_failed", "imu: {}", "gone"));
    output->on_report({SyncFault::kGap, SyncCamera::kLeft, {5}, 2});
    output->on_frame(frame_in(TrackingState::kInit, 0), {}, Eigen::Vector3d::Zero());
    for (int k = 1; k <= 5; ++k) {
        output->on_frame(frame_in(TrackingState::kTracking, k), {}, Eigen::Vector3d::Zero());
    }
    output->on_frame(frame_in(TrackingState::kLost, 6), {}, Eigen::Vector3d::Zero());
    const std::atomic<bool> stopping{true};
    std::thread sender([&] { output->send_poses(stopping); });
    std::thread writer([&] { output->write_files(stopping); });
    sender.join();
    writer.join();
    CHECK(output->frames() == 7);
    CHECK(sink.sent.size() == 6);  // nothing before the start
    CHECK(sink.sent.back().quality == -1);
    CHECK(output->counters().refused == 0);
    CHECK(recorder.summary().frames == 7);
    CHECK(recorder.summary().estimates == 5);
    REQUIRE(output->latencies_ms().size() == 3);  // the newest
    CHECK(*std::min_element(output->latencies_ms().begin(), output->latencies_ms().end()) == Approx(1700.0));
    const FrameStatus status = output->status();
    CHECK(status.frames == 7);
    CHECK(status.health.state == TrackingState::kLost);
    REQUIRE(status.events.size() == 2);
    CHECK(status.events[0] == "imu: gone");
    CHECK(status.events[1] == "synchroniser: left camera: gap (value 2, at 5 ns)");
    CHECK(test::read_file(dir.file("warnings.txt.part")) ==
          "source_failed: imu: gone\nsynchroniser: synchroniser: left camera: gap (value 2, at 5 ns)\n");
}

TEST_CASE("when nobody takes them, poses and frames are dropped and counted, and never wait") {
    const ManualClock clock;
    FrameRecorder recorder("");
    auto output = std::make_unique<OutputThreads>(clock, ImuNoise{}, std::vector<OdometrySink*>{}, recorder,
                                                  std::vector<EventQueue*>{}, 10);
    for (int k = 0; k < 100; ++k) {
        output->on_frame(frame_in(TrackingState::kTracking, k), {}, Eigen::Vector3d::Zero());
    }
    CHECK(output->counters().poses_dropped == 68);
    CHECK(output->counters().frames_dropped == 36);
}

TEST_CASE("a full disc ends the writing, not the run") {
    if (!std::filesystem::exists("/dev/full")) {
        return;
    }
    const test::TempDir dir;
    std::filesystem::create_symlink("/dev/full", dir.file("health.csv"));
    const ManualClock clock({3'000'000'000});
    FrameRecorder recorder(dir.path());
    recorder.open();
    RecordingSink sink;
    sink.answer = Status::kIo;
    auto output = std::make_unique<OutputThreads>(clock, ImuNoise{}, std::vector<OdometrySink*>{&sink}, recorder,
                                                  std::vector<EventQueue*>{}, 10);
    for (int k = 0; k < 5; ++k) {
        output->on_frame(frame_in(TrackingState::kTracking, k), {}, Eigen::Vector3d::Zero());
    }
    const std::atomic<bool> stopping{true};
    output->write_files(stopping);
    output->send_poses(stopping);
    CHECK(output->failure().find("health.csv: cannot be written") != std::string::npos);
    CHECK(output->status().frames == 5);
    CHECK(sink.sent.size() == 5);
    CHECK(output->counters().refused == 5);
}

}  // namespace
}  // namespace facet
