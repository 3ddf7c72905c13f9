// SPDX-License-Identifier: BSD-2-Clause
// `facet run` with all its threads, on a simulated flight instead of sensors, against a replay of the same log.
#include "app/run/live_run.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string_view>
#include <thread>

#include "app/config/config_file.h"
#include "app/lab/convert/opened_log.h"
#include "app/lab/replay/replay.h"
#include "app/view/live_view.h"
#include "platform/linux/linux_clock.h"
#include "tests/app/run/live_flight.h"
#include "tests/support/asl_sources.h"
#include "tests/support/paced_sources.h"
#include "tests/support/stereo_as_camera.h"
#include "tests/support/temp_dir.h"

namespace facet::live_run_test {
namespace {

class CountingSink final : public OdometrySink {
public:
    Status send(const Odometry& odometry) override {
        increasing = increasing && (count == 0 || odometry.stamp > last);
        last = odometry.stamp;
        newest = odometry;
        first = count == 0 ? odometry.stamp : first;
        first_in_map = first_in_map.ns == 0 && odometry.is_in_map ? odometry.stamp : first_in_map;
        ++count;
        return Status::kOk;
    }
    std::size_t count = 0;
    Timestamp first;
    Timestamp last;
    Timestamp first_in_map;
    Odometry newest;
    bool increasing = true;
};

/// The log's frame stamps as edges, the first `last` of them; then lets the cameras go.
class LogTrigger final : public TriggerSource {
public:
    LogTrigger(Clock& clock, std::atomic<bool>& go, std::uint32_t last = 1'000'000)
        : stereo_(clock, flight().source()), go_(go), last_(last) {}
    Status start() override { return stereo_.start(); }
    void stop() override { stereo_.stop(); }
    ClockDomain clock() const override { return ClockDomain::kMonotonic; }
    SourceCounters counters() const override { return stereo_.counters(); }
    std::string_view problem() const override { return stereo_.problem(); }
    Status next(Duration timeout, TriggerEdge& edge) override {
        StereoFrame frame;
        const Status status = count_ < last_ ? stereo_.next(timeout, frame) : Status::kEndOfStream;
        if (status == Status::kEndOfStream) {
            go_ = true;
        }
        FACET_TRY(status);
        edge = {frame.stamp, 100 + count_++, true};
        return Status::kOk;
    }

private:
    AslStereoSource stereo_;
    std::atomic<bool>& go_;
    std::uint32_t last_;
    std::uint32_t count_ = 0;
};

/// Gives nothing but failures instead of the samples from `first` on, `count` of them.
template <class Base, class Sample>
class Flaky final : public Base {
public:
    Flaky(Base& inner, std::uint64_t first, std::uint64_t count) : inner_(inner), first_(first), last_(first + count) {}
    Status start() override { return inner_.start(); }
    void stop() override { inner_.stop(); }
    ClockDomain clock() const override { return inner_.clock(); }
    SourceCounters counters() const override {
        SourceCounters c = inner_.counters();
        c.errors = failed_ ? 1 : 0;
        c.recoveries = back_ ? 1 : 0;
        return c;
    }
    std::string_view problem() const override { return failed_ ? "unplugged" : ""; }
    Status next(Duration timeout, Sample& sample) override {
        Sample taken;
        FACET_TRY(inner_.next(timeout, taken));
        const std::uint64_t n = taken_++;
        if (n >= first_ && n < last_) {
            failed_ = true;
            return Status::kIo;
        }
        back_ = back_ || failed_;
        sample = std::move(taken);
        return Status::kOk;
    }

private:
    Base& inner_;
    std::uint64_t first_;
    std::uint64_t last_;
    std::uint64_t taken_ = 0;
    bool failed_ = false;
    bool back_ = false;
};

std::uint64_t dropped(const RunSummary& summary, std::string_view what) {
    const std::vector<NamedCounter>& drops = summary.live->drops;
    const auto found = std::find_if(drops.begin(), drops.end(), [&](const NamedCounter& d) { return d.name == what; });
    REQUIRE(found != drops.end());
    return found->value;
}

nlohmann::json summary_of(const std::string& folder) {
    return nlohmann::json::parse(test::read_file(folder + "/summary.json"));
}

TEST_CASE("a run on a recorded flight gives the bytes of its replay") {
    const test::TempDir dir;
    Rig rig;
    CountingSink sink;
    Vehicle vehicle = flight().vehicle(dir.file("out"));
    vehicle.odometry.rate_hz = 0.0;
    LiveView view({});
    LiveRun run(rig.clock, vehicle, {&rig.camera, nullptr, nullptr, &rig.imu}, {&sink});
    run.show_to(&view);
    const RunSummary summary = run_to_end(run);
    CHECK(view.account().offered == summary.frames);
    CHECK(run.failure().empty());
    CHECK_FALSE(summary.interrupted);
    CHECK(summary.frames == flight().run().frames);
    CHECK(summary.estimates == flight().run().estimates);
    CHECK(summary.imu_samples == flight().run().imu_samples);
    CHECK(summary.keyframes == flight().run().keyframes);
    REQUIRE(summary.estimates > 50);
    for (const char* name : {"trajectory.tum", "trajectory.csv", "covariance.csv", "health.csv", "mesh.csv",
                             "planes.csv", "mesh.ply", "mesh_live.ply", "planes.json"}) {
        INFO(name);
        CHECK(test::read_file(dir.file(std::string("out/") + name)) ==
              test::read_file(flight().replayed() + "/" + name));
    }
    CHECK(sink.count == summary.estimates);
    CHECK(sink.increasing);
    const nlohmann::json live = summary_of(dir.file("out"))["live"];
    CHECK(live["latency_ms"]["count"] == summary.estimates);
    CHECK(live["drops"]["late_frames"] == 0);
    CHECK(live["sources"]["cameras"]["delivered"] == summary.frames);
    CHECK(live["sources"]["imu"]["rejected"] == 0);
    CHECK(live["poses"] == sink.count);
}

/// A camera at an ordinary rate by the wall's clock, so that a recorder on a busy machine keeps up.
class UnhurriedCamera final : public CameraSource {
public:
    explicit UnhurriedCamera(CameraSource& inner) : inner_(inner) {}
    Status start() override { return inner_.start(); }
    void stop() override { inner_.stop(); }
    ClockDomain clock() const override { return inner_.clock(); }
    SourceCounters counters() const override { return inner_.counters(); }
    std::string_view problem() const override { return inner_.problem(); }
    Status next(Duration timeout, CameraFrame& frame) override {
        FACET_TRY(inner_.next(timeout, frame));
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
        return Status::kOk;
    }

private:
    CameraSource& inner_;
};

/// Everything but calibration and config of a replay of what was recorded in `folder`.
ReplayOptions replay_of(const std::string& folder, const std::string& out) {
    ReplayOptions replay;
    replay.dataset = folder;
    replay.out = out;
    replay.show_progress = false;
    return replay;
}

/// Replays it with the parameters and the calibration in it, and compares with what the run has left in `flown`.
void check_replay(ReplayOptions replay, const std::string& root, const Vehicle& vehicle, const std::string& flown) {
    load_config(root + "/parameters.yaml", replay.config);
    replay.config.regularity.mode = vehicle.config.regularity.mode;
    replay.config.map.enabled = false;  // as in flight
    replay.calibration = load_calibration(root, "", "");
    replay.config.imu_noise = replay.calibration.noise;
    const RunSummary replayed = run_replay(replay, false);
    CHECK(replayed.warnings.empty());
    for (const char* name : {"trajectory.tum", "trajectory.csv", "covariance.csv", "health.csv", "mesh.csv",
                             "planes.csv", "mesh.ply", "mesh_live.ply", "planes.json"}) {
        INFO(name);
        CHECK(test::read_file(replay.out + "/" + name) == test::read_file(flown + "/" + name));
    }
}

TEST_CASE("the log of a run replays to the bytes of the run") {
    const test::TempDir dir;
    const LogForm form = GENERATE(LogForm::kFolder, LogForm::kMcap);
    const Vehicle vehicle = flight().vehicle(dir.file("out"));
    RunSummary summary;
    {
        Rig rig;
        UnhurriedCamera camera(rig.camera);
        LiveRun run(rig.clock, vehicle, {&camera, nullptr, nullptr, &rig.imu}, {});
        run.record(form);
        summary = run_to_end(run);
        CHECK(run.failure().empty());
        REQUIRE(summary.estimates > 50);
    }
    const nlohmann::json drops = summary_of(dir.file("out"))["live"]["drops"];
    CHECK(drops["pairs_not_recorded"] == 0);
    CHECK(drops["samples_not_recorded"] == 0);
    if (form == LogForm::kFolder) {
        check_replay(replay_of(dir.file("out"), dir.file("replay")), dir.file("out/mav0"), vehicle, dir.file("out"));
    } else {
        const std::string path = dir.file("out/flight.mcap");
        const OpenedLog opened(path, [](const std::string& line) { FAIL(line); });
        ReplayOptions replay = replay_of(path, dir.file("replay"));
        replay.files = opened.files();
        replay.truth_folder = opened.folder();
        check_replay(replay, opened.root(), vehicle, dir.file("out"));
        // The estimates are there as well.
        std::map<std::string, std::uint64_t> counts;
        std::map<std::string, std::string> last;
        McapFile file(path, [](const std::string& line) { FAIL(line); });
        CHECK(file.is_whole());
        McapFile::Cursor cursor;
        for (McapMessage message; file.next(cursor, message);) {
            const std::string& topic = file.channels().at(message.channel).topic;
            ++counts[topic];
            last[topic] = std::string(message.data.begin(), message.data.end());
        }
        CHECK(drops["estimates_not_recorded"] == 0);
        CHECK(counts["/pose"] == summary.estimates);
        CHECK(counts["/health"] == summary.frames);
        CHECK(counts["/timing"] == summary.frames);
        for (const char* topic : {"/path", "/tf", "/mesh", "/planes", "/calibration", "/drops"}) {
            INFO(topic);
            CHECK(counts[topic] > 1);
        }
        const nlohmann::json pose = nlohmann::json::parse(last["/pose"])["pose"]["position"];
        CHECK(pose["x"].get<double>() == summary.last.state.p_W_B.x());
        CHECK(pose["z"].get<double>() == summary.last.state.p_W_B.z());
        const nlohmann::json counted = nlohmann::json::parse(last["/drops"])["counts"];
        CHECK(counted["imu_delivered"].get<std::uint64_t>() > 0);
        CHECK(counted["pairs_not_recorded"] == 0);
    }
    Rig second;
    LiveRun again(second.clock, vehicle, {&second.camera, nullptr, nullptr, &second.imu}, {});
    again.record(form);
    CHECK_THROWS_WITH(again.start(), Catch::Contains("there is a log already"));
}

TEST_CASE("sinks get the newest estimate at a rate of their own, never backwards in time") {
    Rig rig;
    CountingSink sink;
    Vehicle vehicle = flight().vehicle("");
    vehicle.odometry.rate_hz = 200.0;
    LiveRun run(rig.clock, vehicle, {&rig.camera, nullptr, nullptr, &rig.imu}, {&sink});
    const RunSummary summary = run_to_end(run);
    REQUIRE(summary.estimates > 50);
    CHECK(sink.increasing);
    CHECK(sink.count == summary.live->poses);
    // A value for nearly every sample since the first estimate: ten between two frames.
    CHECK(sink.count > 8 * summary.estimates);
    CHECK(sink.count < 11 * summary.estimates);
    // The samples up to the newest one, not up to the last frame only.
    CHECK(sink.last >= summary.last.stamp);
}

TEST_CASE("a run in the map of an earlier run is located within three seconds, and sinks know where") {
    std::vector<MappedPlace> map;
    Eigen::Vector3d end_M;
    const auto in_map = [](const Odometry& o) {
        return Eigen::Vector3d(Eigen::AngleAxisd(o.map_yaw, Eigen::Vector3d::UnitZ()) * o.p_W_B + o.map_p);
    };
    {
        Rig rig;
        CountingSink sink;
        LiveRun run(rig.clock, flight().vehicle(""), {&rig.camera, nullptr, nullptr, &rig.imu}, {&sink});
        run.remember_places({});
        (void)run_to_end(run);
        REQUIRE(sink.newest.is_in_map);
        end_M = in_map(sink.newest);
        for (std::size_t i = 0; i < run.places()->size(); ++i) {
            map.push_back(run.places()->place(i));
        }
    }
    REQUIRE(!map.empty());
    for (MappedPlace& place : map) {
        place.T_M_K = YawPose{1.0, {3.0, -2.0, 0.5}} * place.T_M_K;
    }
    Rig rig;
    CountingSink sink;
    LiveRun run(rig.clock, flight().vehicle(""), {&rig.camera, nullptr, nullptr, &rig.imu}, {&sink});
    run.remember_places(map);
    (void)run_to_end(run);
    REQUIRE(sink.newest.is_in_map);
    CHECK((sink.first_in_map - sink.first).seconds() < 3.0);
    CHECK((in_map(sink.newest) - YawPose{1.0, {3.0, -2.0, 0.5}} * end_M).norm() < 0.02);
}

TEST_CASE("two cameras and a trigger line are put together, and estimate the same flight") {
    const test::TempDir dir;
    StillClock clock;
    std::atomic<bool> go{false};
    ViewCamera<> left_view(clock, true, go);
    ViewCamera<> right_view(clock, false, go);
    LogTrigger trigger(clock, go);
    AslImuSource log_imu(clock, flight().source());
    Pace pace(2, Duration::from_seconds(0.06));  // less than the synchroniser waits for a right image
    PacedCamera left(left_view, pace, 0);
    PacedCamera right(right_view, pace, 1);
    PacedImu imu(log_imu, pace);
    Vehicle vehicle = flight().vehicle(dir.file("out"));
    vehicle.cameras.side_by_side = false;
    vehicle.trigger.emplace();
    LiveRun run(clock, vehicle, {&left, &right, &trigger, &imu}, {});
    const RunSummary summary = run_to_end(run);
    // The first frames are not believed until five agree.
    CHECK(summary.frames == flight().run().frames - 4);
    CHECK(summary.live->findings[static_cast<std::size_t>(SyncFault::kDoubtful)].value == 8);
    CHECK(summary.last.health.state == TrackingState::kTracking);
    // The estimated time offset is part of an estimate's stamp, and may differ a little.
    CHECK(std::abs((summary.last.stamp - flight().run().last.stamp).ns) < 2'000'000);
    CHECK((summary.last.state.p_W_B - flight().run().last.state.p_W_B).norm() < 0.05);
}

TEST_CASE("a trigger wire that breaks in flight costs a moment; from then on the estimate is DEGRADED and says why") {
    StillClock clock;
    std::atomic<bool> go{false};
    ViewCamera<5> left_view(clock, true, go);  // four wait for edges until these are given up
    ViewCamera<5> right_view(clock, false, go);
    LogTrigger trigger(clock, go, 40);
    AslImuSource log_imu(clock, flight().source());
    Pace pace(2, Duration::from_seconds(0.06));
    PacedCamera left(left_view, pace, 0);
    PacedCamera right(right_view, pace, 1);
    PacedImu imu(log_imu, pace);
    Vehicle vehicle = flight().vehicle("");
    vehicle.cameras.side_by_side = false;
    vehicle.trigger.emplace();
    LiveRun run(clock, vehicle, {&left, &right, &trigger, &imu}, {});
    const RunSummary summary = run_to_end(run);
    // Whatever the load, only frames not yet believed, and those that wait in vain for an edge, are never given
    // to the estimator. How many of the rest give way to newer ones depends on the machine.
    CHECK(summary.frames + dropped(summary, "late_frames") > flight().run().frames - 8);
    CHECK(summary.frames > flight().run().frames - 21);
    CHECK(summary.live->findings[static_cast<std::size_t>(SyncFault::kTriggerSilent)].value > 0);
    CHECK(summary.last.health.state == TrackingState::kDegraded);
    CHECK((summary.last.health.reasons & kReasonTriggerSilent) != 0);
    CHECK((summary.last.state.p_W_B - flight().run().last.state.p_W_B).norm() < 0.05);
}

TEST_CASE("sensors that fail and come back are reported, counted and survived") {
    const test::TempDir dir;
    Rig rig;
    // 0.2 s without inertial samples, and 0.3 s without images, in flight.
    Flaky<ImuSource, ImuSample> imu(rig.imu, 420, 40);
    Flaky<CameraSource, CameraFrame> camera(rig.camera, 40, 6);
    const Vehicle vehicle = flight().vehicle(dir.file("out"));
    LiveRun run(rig.clock, vehicle, {&camera, nullptr, nullptr, &imu}, {});
    const RunSummary summary = run_to_end(run);
    CHECK(summary.frames == flight().run().frames - 6);
    CHECK(summary.last.health.state != TrackingState::kLost);
    CHECK(summary.last.health.imu_gaps >= 1);
    CHECK(summary.warnings.at("source_failed") == 2);
    CHECK(summary.warnings.at("recovered") == 2);
    const std::string log = test::read_file(dir.file("out/warnings.txt"));
    CHECK(log.find("source_failed: imu: unplugged") != std::string::npos);
    CHECK(log.find("recovered: cameras: works again") != std::string::npos);
    const nlohmann::json sources = summary_of(dir.file("out"))["live"]["sources"];
    CHECK(sources["imu"]["errors"] == 1);
    CHECK(sources["imu"]["recoveries"] == 1);
    CHECK(sources["cameras"]["recoveries"] == 1);
}

TEST_CASE("a left camera that dies in flight leaves the right one, which takes its role, and the reason is said") {
    StillClock clock;
    std::atomic<bool> go{false};
    ViewCamera<> left_view(clock, true, go);
    ViewCamera<> right_view(clock, false, go);
    LogTrigger trigger(clock, go);
    AslImuSource log_imu(clock, flight().source());
    Pace pace(2, Duration::from_seconds(0.15));  // more than a right image waits for its partner
    PacedCamera living(left_view, pace, 0);
    PacedCamera right(right_view, pace, 1);
    PacedImu imu(log_imu, pace);
    Flaky<CameraSource, CameraFrame> left(living, 24, 1'000);
    CountingSink sink;
    Vehicle vehicle = flight().vehicle("");
    vehicle.cameras.side_by_side = false;
    vehicle.trigger.emplace();
    LiveRun run(clock, vehicle, {&left, &right, &trigger, &imu}, {&sink});
    const RunSummary summary = run_to_end(run);
    CHECK(summary.frames > flight().run().frames - 10);
    CHECK(summary.live->findings[static_cast<std::size_t>(SyncFault::kMissingLeft)].value > 30);
    // So soon after take-off one camera has not yet told the scale: INIT or DEGRADED.
    CHECK(summary.last.health.state != TrackingState::kTracking);
    CHECK(summary.last.health.state != TrackingState::kLost);
    CHECK((summary.last.health.reasons & kReasonOneCamera) != 0);
    CHECK(summary.last.health.is_exchanged);
    CHECK(sink.increasing);
}

TEST_CASE("a vehicle with one camera gives every one of its frames to the estimator, and misses no other") {
    StillClock clock;
    const std::atomic<bool> go{true};
    ViewCamera<> view(clock, true, go);
    AslImuSource log_imu(clock, flight().source());
    Pace pace(1, Duration::from_seconds(0.4));
    PacedCamera left(view, pace, 0);
    PacedImu imu(log_imu, pace);
    Vehicle vehicle = flight().vehicle("");
    vehicle.cameras.side_by_side = false;
    const StereoRig& rig = vehicle.calibration.rig;
    vehicle.calibration.rig = StereoRig::monocular(rig.left, rig.T_B_C0);
    LiveRun run(clock, vehicle, {&left, nullptr, nullptr, &imu}, {});
    const RunSummary summary = run_to_end(run);
    // By the clocks' offset found, the last frame may lie after the log's last inertial sample; it is not waited for.
    CHECK(dropped(summary, "late_frames") <= 1);
    CHECK(summary.frames + dropped(summary, "late_frames") == flight().run().frames);
    CHECK(summary.live->findings[static_cast<std::size_t>(SyncFault::kMissingRight)].value == 0);
    CHECK(summary.last.health.state != TrackingState::kLost);
    CHECK((summary.last.health.reasons & (kReasonOneCamera | kReasonNoRightImage)) == 0);
}

/// The flight as it was recorded, from 0.2 s from now on.
AslSourceOptions at_real_pace(const Clock& clock) {
    AslSourceOptions options = flight().source();
    AslDataset log;
    std::string error;
    REQUIRE(ok(log.open(options.folder, {}, {}, error)));
    options.pace = {log.log_begin(), clock.now() + Duration::from_seconds(0.2), false, false};
    return options;
}

TEST_CASE("a stop in mid-flight leaves complete files") {
    const test::TempDir dir;
    LinuxClock clock;
    const AslSourceOptions options = at_real_pace(clock);
    AslStereoSource stereo(clock, options);
    AslImuSource imu(clock, options);
    const CameraIntrinsics k = flight().vehicle("").calibration.rig.left.intrinsics();
    StereoAsCamera<6> camera(stereo, k.width, k.height);
    CountingSink sink;
    const Vehicle vehicle = flight().vehicle(dir.file("out"));
    LiveRun run(clock, vehicle, {&camera, nullptr, nullptr, &imu}, {&sink});
    run.start();
    for (int i = 0; i < 1000 && run.frames() < 10; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    const RunSummary summary = run.stop();
    CHECK(summary.interrupted);
    REQUIRE(summary.frames >= 10);
    CHECK(summary.frames < flight().run().frames);
    // On a machine that falls behind, estimates are carried on between frames.
    CHECK(rows(dir.file("out/health.csv")) == 1 + summary.frames + summary.reports_without_frame);
    CHECK(rows(dir.file("out/trajectory.tum")) == summary.estimates);
    CHECK(sink.count > summary.estimates);
    const nlohmann::json json = summary_of(dir.file("out"));
    CHECK(json["interrupted"] == true);
    CHECK(json["live"]["latency_ms"]["median"] > 0.0);
    // Frames of the live clock: used, late, or not ready in time.
    CHECK(json["frames_listed"].get<std::size_t>() ==
          summary.frames + json["live"]["drops"]["late_frames"].get<std::size_t>());
}

TEST_CASE("a source that cannot start ends the run before it begins") {
    Rig rig;
    AslSourceOptions nowhere = flight().source();
    nowhere.folder = "/no/such/log";
    AslImuSource imu(rig.clock, nowhere);
    const Vehicle vehicle = flight().vehicle("");
    LiveRun run(rig.clock, vehicle, {&rig.camera, nullptr, nullptr, &imu}, {});
    CHECK_THROWS_WITH(run.start(), "imu: /no/such/log: no such folder");
    CHECK(run.folder().empty());
}

}  // namespace
}  // namespace facet::live_run_test
