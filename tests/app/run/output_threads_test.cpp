// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/output_threads.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <thread>

#include "tests/support/scripted_source.h"
#include "tests/support/temp_dir.h"

namespace facet::output_threads_test {
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

/// A frame's estimate, and the frame when it is finished.
void give(OutputThreads& output, const FrameResult& frame, const Belief& belief) {
    output.on_estimate(frame, belief, Eigen::Vector3d::Zero());
    output.on_frame(frame, {});
}

/// A pose a frame.
const VehicleOdometry kByFrame{0.0, 0.0};

class RecordingSink final : public OdometrySink {
public:
    Status answer = Status::kOk;
    std::vector<Odometry> sent;
    std::vector<std::string> told;
    void report(const StateChange& change) override { told.emplace_back(change.text.data()); }
    Status send(const Odometry& odometry) override {
        sent.push_back(odometry);
        return answer;
    }
};

/// Poses at the inertial sensor's rate, as they are given to one sink; the sending thread's turns are the test's.
struct FastOutput {
    test::TempDir dir;
    ManualClock clock{{3'000'000'000}};
    FrameRecorder recorder{dir.path()};
    RecordingSink sink;
    OutputThreads output{clock, ProgramConfig{}, VehicleOdometry{200.0, 0.0, {}}, {&sink}, recorder, {}, 10};
    const std::atomic<bool> stopping{true};

    FastOutput() { recorder.open(); }
    void add_sample(std::int64_t ms) {
        output.on_sample({{ms * 1'000'000}, Eigen::Vector3d::Zero(), {0.0, 0.0, 9.81}});
    }
    void add_frame(int k) {
        const FrameResult frame = frame_in(TrackingState::kTracking, k);
        Belief belief;
        belief.stamp = frame.frame_stamp;
        belief.state.p_W_B.x() = k;
        give(output, frame, belief);
    }
    void send() { output.send_poses(stopping); }
};

TEST_CASE("poses reach the sinks and frames the files, however early the stop comes") {
    const test::TempDir dir;
    const ManualClock clock({3'000'000'000});
    FrameRecorder recorder(dir.path());
    recorder.open();
    RecordingSink sink;
    EventQueue events;
    auto output = std::make_unique<OutputThreads>(clock, ProgramConfig{}, kByFrame, std::vector<OdometrySink*>{&sink},
                                                  recorder, std::vector<EventQueue*>{&events}, 3);
    (void)events.push(RunEvent::make("source_failed", "imu: {}", "gone"));
    output->on_report({SyncFault::kGap, SyncCamera::kLeft, {5}, 2});
    give(*output, frame_in(TrackingState::kInit, 0), Belief{});
    for (int k = 1; k <= 5; ++k) {
        give(*output, frame_in(TrackingState::kTracking, k), Belief{});
    }
    give(*output, frame_in(TrackingState::kLost, 6), Belief{});
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

/// Hangs in a pose until it is let go, as in a driver that waits for its hardware.
class HangingSink final : public OdometrySink {
public:
    Status send(const Odometry&) override {
        is_in = true;
        while (hangs) {
            std::this_thread::yield();
        }
        return Status::kOk;
    }
    std::atomic<bool> hangs{true};
    std::atomic<bool> is_in{false};
};

/// A clock that threads may look at while the test moves it.
class SharedClock final : public Clock {
public:
    Timestamp now() const override { return {ns.load()}; }
    ClockPair read_pair() const override { return {now(), now(), {}}; }
    void sleep_until(Timestamp) override {}
    std::atomic<std::int64_t> ns{3'000'000'000};
};

TEST_CASE("the thread that gives no sign of life is named: inertial sensor, estimator or sinks") {
    SharedClock clock;
    FrameRecorder recorder("");
    HangingSink sink;
    const ProgramConfig config;
    const auto output = std::make_unique<OutputThreads>(clock, config, kByFrame, std::vector<OdometrySink*>{&sink},
                                                        recorder, std::vector<EventQueue*>{}, 1);
    const auto name = [](const char* thread) { return std::string(thread == nullptr ? "" : thread); };
    const auto pass = [&](double seconds) { clock.ns += Duration::from_seconds(seconds).ns; };
    const auto sample = [&] { output->on_sample({clock.now(), Eigen::Vector3d::Zero(), {0.0, 0.0, 9.81}}); };
    CHECK(name(output->silent_thread()) == "imu");  // not one sample yet
    std::atomic<bool> stopping{false};
    sample();
    output->on_beat();
    CHECK(output->silent_thread() == nullptr);
    // GIVEN a sink that hangs in its driver WHEN the others go on THEN the sinks' thread is named
    give(*output, frame_in(TrackingState::kTracking, 1), Belief{});
    std::thread sender([&] { output->send_poses(stopping); });
    while (!sink.is_in) {
        std::this_thread::yield();
    }
    CHECK(output->silent_thread() == nullptr);
    pass(0.2);
    sample();
    output->on_beat();
    CHECK(name(output->silent_thread()) == "sinks");
    CHECK(output->hanging_thread() == nullptr);  // not long enough to end the program
    pass(config.health.lost_after_s);
    sample();
    output->on_beat();
    CHECK(name(output->hanging_thread()) == "sinks");
    // WHEN it is let go THEN nothing is wrong
    sink.hangs = false;
    stopping = true;
    sender.join();
    CHECK(output->silent_thread() == nullptr);
    CHECK(output->hanging_thread() == nullptr);
    pass(config.health.lost_after_s + 0.1);
    sample();
    CHECK(name(output->silent_thread()) == "estimator");
    CHECK(name(output->hanging_thread()) == "estimator");
    output->on_beat();
    pass(10.0);
    output->on_beat();
    CHECK(name(output->silent_thread()) == "imu");
    CHECK(output->hanging_thread() == nullptr);  // a sensor's driver reopens it
}

TEST_CASE("when nobody takes them, poses and frames are dropped and counted, and never wait") {
    const ManualClock clock;
    FrameRecorder recorder("");
    auto output = std::make_unique<OutputThreads>(clock, ProgramConfig{}, kByFrame, std::vector<OdometrySink*>{},
                                                  recorder, std::vector<EventQueue*>{}, 10);
    for (int k = 0; k < 100; ++k) {
        give(*output, frame_in(TrackingState::kTracking, k), Belief{});
    }
    for (int k = 0; k < 1030; ++k) {
        output->on_sample({{k * 5'000'000LL}, Eigen::Vector3d::Zero(), {0.0, 0.0, 9.81}});
    }
    CHECK(output->counters().poses_dropped == 68 + 6);
    CHECK(output->counters().frames_dropped == 36);
}

TEST_CASE("between frames the newest estimate goes on with the inertial samples; latency is counted once a frame") {
    const auto fast = std::make_unique<FastOutput>();
    const auto imu = [&](std::int64_t from_ms, std::int64_t to_ms) {
        for (std::int64_t ms = from_ms; ms <= to_ms; ms += 5) {
            fast->add_sample(ms);
        }
    };
    for (int k = 0; k < 2; ++k) {
        imu(1000 + 50 * k, 1045 + 50 * k);
        fast->add_frame(k);
        fast->send();
    }
    imu(1100, 1100);
    fast->send();
    const std::vector<Odometry>& sent = fast->sink.sent;
    REQUIRE(sent.size() == 11);
    for (std::size_t i = 0; i < sent.size(); ++i) {
        CHECK(sent[i].stamp == Timestamp{(1050 + 5 * static_cast<std::int64_t>(i)) * 1'000'000});
        CHECK(sent[i].p_W_B.x() == Approx(i < 10 ? 0.0 : 1.0));
    }
    CHECK(fast->output.counters().poses_sent == 11);
    REQUIRE(fast->output.latencies_ms().size() == 2);
    CHECK(fast->output.latencies_ms()[0] == Approx(2000.0));
    CHECK(fast->output.latencies_ms()[1] == Approx(1950.0));
}

TEST_CASE("an estimator that hangs is detected within 200 ms and reported, and its poses go on as DEGRADED") {
    const auto fast = std::make_unique<FastOutput>();
    const OutputThreads& output = fast->output;
    const RecordingSink& sink = fast->sink;
    std::int64_t sample_ms = 1000;
    // What the sensors and the sending thread do for so long, the estimator's thread hanging.
    const auto pass = [&](std::int64_t ms) {
        fast->clock.advance(Duration{ms * 1'000'000});
        for (const std::int64_t end = sample_ms + ms; sample_ms < end; sample_ms += 5) {
            fast->add_sample(sample_ms);
        }
        fast->send();
    };
    pass(500);  // nothing was ever heard of it: it is about to start
    fast->add_frame(0);
    pass(5);  // a frame counts from the next sample on
    pass(140);
    REQUIRE_FALSE(sink.sent.empty());
    CHECK(sink.sent.back().quality == 70);
    CHECK(sink.told == std::vector<std::string>{"facet: TRACKING"});

    pass(50);
    CHECK(sink.sent.back().quality == 30);
    REQUIRE(sink.told.size() == 2);
    CHECK(sink.told.back() == "facet: DEGRADED stalled");
    CHECK(output.hanging_thread() == nullptr);  // poses are good for a while
    pass(2900);
    CHECK(std::string(output.hanging_thread()) == "estimator");
    CHECK(sink.sent.back().quality == -1);
    REQUIRE(sink.told.size() == 3);
    CHECK(sink.told.back() == "facet: LOST stalled");

    fast->add_frame(61);
    CHECK(output.hanging_thread() == nullptr);
    pass(5);
    pass(5);
    CHECK(sink.sent.back().quality == 70);
    CHECK(sink.told.back() == "facet: TRACKING");
    fast->output.on_end();  // what has ended is not expected to say anything
    pass(1000);
    CHECK(sink.sent.back().quality == 70);
    pass(5000);
    CHECK(output.hanging_thread() == nullptr);
    fast->output.write_files(fast->stopping);
    const FrameStatus status = fast->output.status();
    REQUIRE(status.events.size() == 2);
    CHECK(status.events[0] == "estimator: no sign of life for 195 ms; poses go on without it");
    CHECK(status.events[1] == "estimator: works again");
}

TEST_CASE("reports an inertial sensor that falls silent, since no frame can come") {
    const auto fast = std::make_unique<FastOutput>();
    const RecordingSink& sink = fast->sink;
    // The estimator's thread is alive, and waits.
    const auto pass = [&](std::int64_t ms) {
        fast->clock.advance(Duration{ms * 1'000'000});
        fast->output.on_beat();
        fast->send();
    };
    const auto frame = [&](int k) {
        fast->add_sample(50 * k);
        fast->add_frame(k);
    };
    frame(0);
    pass(140);
    CHECK(sink.told == std::vector<std::string>{"facet: TRACKING"});
    pass(60);
    CHECK(sink.told.back() == "facet: DEGRADED imu_gap");
    pass(3000);
    CHECK(sink.told.back() == "facet: LOST imu_gap");
    Health last;
    fast->output.add_end(last);
    CHECK(last.state == TrackingState::kLost);
    CHECK(last.reasons == kReasonImuGap);

    fast->add_sample(50);
    pass(5);  // readings alone do not say where the vehicle is
    CHECK(sink.told.back() == "facet: LOST imu_gap");
    frame(1);
    pass(5);
    pass(5);
    CHECK(sink.told.back() == "facet: TRACKING");
    CHECK(sink.told.size() == 4);
    fast->output.on_end();
    fast->clock.advance({1'000'000'000});
    fast->send();
    CHECK(sink.told.size() == 4);
}

TEST_CASE("a full disk ends the writing, not the run") {
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
    auto output = std::make_unique<OutputThreads>(clock, ProgramConfig{}, kByFrame, std::vector<OdometrySink*>{&sink},
                                                  recorder, std::vector<EventQueue*>{}, 10);
    for (int k = 0; k < 5; ++k) {
        give(*output, frame_in(TrackingState::kTracking, k), Belief{});
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
}  // namespace facet::output_threads_test
