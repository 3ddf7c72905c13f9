// SPDX-License-Identifier: BSD-2-Clause
#include "app/pipeline/frame_recorder.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/support/input_error_text.h"
#include "tests/support/temp_dir.h"

namespace facet::frame_recorder_test {
namespace {

FrameResult tracked_frame(int k) {
    FrameResult frame;
    frame.frame_stamp = {1'000'000'000 + k * 50'000'000LL};
    frame.output_stamp = frame.frame_stamp;
    frame.estimate.stamp = frame.frame_stamp;
    frame.estimate.health.state = TrackingState::kTracking;
    frame.estimate.state.p_W_B.x() = 0.1 * k;
    frame.is_usable = true;
    frame.timing.total.wall_ms = k;
    return frame;
}

DepartedFace face(std::uint32_t first) {
    DepartedFace f;
    f.landmark = {LandmarkId{first}, LandmarkId{first + 1}, LandmarkId{first + 2}};
    f.p_W = {Eigen::Vector3f::UnitX(), Eigen::Vector3f::UnitY(), Eigen::Vector3f::UnitZ()};
    return f;
}

TEST_CASE("the account counts frames by what became of them") {
    FrameRecorder recorder("");
    recorder.write(tracked_frame(0), {});
    recorder.write(tracked_frame(1), {});
    FrameResult refused = tracked_frame(2);
    refused.status = Status::kOutOfOrder;
    refused.is_usable = false;
    recorder.write(refused, {});
    FrameResult early = refused;
    early.status = Status::kNotReady;
    recorder.write(early, {});
    FrameResult broken = tracked_frame(5);
    broken.estimate.state.p_W_B.y() = std::numeric_limits<double>::quiet_NaN();
    recorder.write(broken, {});
    const RunSummary& run = recorder.summary();
    CHECK(run.frames == 5);
    CHECK(run.estimates == 2);
    CHECK(run.frames_refused == 1);
    CHECK(run.frames_not_ready == 1);
    CHECK(run.not_finite);
    CHECK(run.path_m == Approx(0.1));
    CHECK(run.warnings.at("refused_frame") == 1);
    CHECK(run.warnings.at("not_finite_estimate") == 1);
}

TEST_CASE("a run of hours keeps the newest frames' times and a bounded mesh") {
    FrameRecorder recorder("", {.timed_frames = 10, .mesh_faces = 2});
    const RunSummary::TimedFrame* const memory = recorder.summary().timed.data();
    for (int k = 0; k < 25; ++k) {
        recorder.write(tracked_frame(k), {});
    }
    const RunSummary& run = recorder.summary();
    CHECK(run.frames == 25);
    REQUIRE(run.timed.size() == 10);
    CHECK(run.timed.data() == memory);  // taken at the beginning
    std::vector<int> kept;
    for (const RunSummary::TimedFrame& t : run.timed) {
        kept.push_back(static_cast<int>(t.timing.total.wall_ms));
    }
    std::sort(kept.begin(), kept.end());
    CHECK(kept.front() == 15);
    CHECK(kept.back() == 24);

    RunMesh mesh(2);
    const std::array faces{face(1), face(10), face(20), face(10)};
    mesh.collect(faces);
    CHECK(mesh.faces() == 2);
    CHECK(mesh.dropped() == 1);  // the third; the last one renews the second
}

TEST_CASE("a run that ends before its end leaves an earlier run's files alone, and its own beside them") {
    const test::TempDir dir;
    dir.write("trajectory.tum", "old\n");
    dir.write("summary.json", "{}\n");
    {
        FrameRecorder recorder(dir.path());
        recorder.warn("early", "before anything is written");
        CHECK_FALSE(std::filesystem::exists(dir.file("trajectory.tum.part")));
        recorder.open();
        recorder.write(tracked_frame(0), {});
    }
    CHECK(test::read_file(dir.file("trajectory.tum")) == "old\n");
    CHECK(test::read_file(dir.file("summary.json")) == "{}\n");
    CHECK(test::read_file(dir.file("trajectory.tum.part")).starts_with("1.000000000 "));
    CHECK(test::read_file(dir.file("warnings.txt.part")) == "early: before anything is written\n");
    FrameRecorder recorder(dir.path());
    recorder.open();
    recorder.write(tracked_frame(0), {});
    FramePipeline pipeline;
    recorder.finish(pipeline, nullptr);
    CHECK(test::read_file(dir.file("trajectory.tum")).starts_with("1.000000000 "));
    for (const auto& entry : std::filesystem::directory_iterator(dir.path())) {
        CHECK(entry.path().extension() != TextFile::kPartEnding);
    }
}

TEST_CASE("two runs do not write into one folder") {
    const test::TempDir dir;
    FrameRecorder first(dir.path());
    first.open();
    FrameRecorder second(dir.path());
    CHECK(test::input_error_text([&] { second.open(); }) == dir.path() + ": another run is writing into this folder");
    FramePipeline pipeline;
    first.finish(pipeline, nullptr);
}

TEST_CASE("files are complete after a flush as far as frames were written") {
    const test::TempDir dir;
    FrameRecorder recorder(dir.path());
    recorder.open();
    recorder.write(tracked_frame(0), {});
    recorder.write(tracked_frame(1), {});
    recorder.flush();
    const auto rows = [&](const char* name) {
        const std::string text = test::read_file(dir.file(std::string(name) + TextFile::kPartEnding));
        return std::count(text.begin(), text.end(), '\n');
    };
    CHECK(rows("health.csv") == 3);
    CHECK(rows("timing.csv") == 3);
    CHECK(rows("trajectory.tum") == 2);
    FramePipeline pipeline;
    recorder.finish(pipeline, nullptr);
    CHECK(nlohmann::json::parse(test::read_file(dir.file("summary.json")))["estimates"] == 2);
    CHECK(std::filesystem::exists(dir.file("mesh.ply")));
}

}  // namespace
}  // namespace facet::frame_recorder_test
