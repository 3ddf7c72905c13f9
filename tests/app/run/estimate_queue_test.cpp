// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/estimate_queue.h"

#include <catch2/catch.hpp>
#include <map>
#include <memory>
#include <string>

#include "app/lab/mcap/mcap_file.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/temp_dir.h"

namespace facet::estimate_queue_test {
namespace {

ViewState state_at(int frame) {
    ViewState state;
    state.stamp = {1'000'000'000 + 50'000'000LL * frame};
    state.is_keyframe = frame % 5 == 0;
    state.T_W_B.p.x() = frame;
    return state;
}

FlightViewer::Fillers fillers() {
    return {[](ViewMesh& mesh) { mesh.faces.resize(FlightViewer::kMaxFaces); }, {}, [](CalibrationEstimate&) {}};
}

std::map<std::string, int> topics_of(const std::string& path) {
    std::map<std::string, int> counts;
    McapFile file(path, [](const std::string& line) { FAIL(line); });
    McapFile::Cursor cursor;
    for (McapMessage message; file.next(cursor, message);) {
        ++counts[file.channels().at(message.channel).topic];
    }
    return counts;
}

TEST_CASE("a log that makes everything wait costs estimates, which are counted, and never the estimator") {
    const auto queue = std::make_unique<EstimateQueue>();
    const FlightViewer::Fillers keyframe = fillers();
    const FlightViewer::Fillers frame;
    const test::AllocationGuard guard;
    for (int k = 0; k < 200; ++k) {
        const ViewState state = state_at(k);
        queue->offer(state, state.is_keyframe ? keyframe : frame);
    }
    const std::uint64_t allocations = guard.allocations();
    CHECK(allocations == 0);
    // 200 frames in 10 s: of the states 128 fit, of the meshes, offered until one is taken, 4, of 40 calibrations 8.
    CHECK(queue->dropped() >= 72 + 1 + 32);
    const test::TempDir dir;
    McapWriter writer(dir.file("estimates.mcap"), Compression::kZstd, "", "test");
    EstimateChannels channels(writer);
    queue->pass_on(channels);
    queue->offer(state_at(200), keyframe);  // there is room again
    queue->pass_on(channels);
    writer.close();
    std::map<std::string, int> counts = topics_of(dir.file("estimates.mcap"));
    CHECK(counts["/pose"] == 129);
    CHECK(counts["/health"] == 129);
    CHECK(counts["/mesh"] == 5);
    CHECK(counts["/planes"] == 5);
    CHECK(counts["/calibration"] == 9);
    CHECK(counts["/path"] == 7 + 1);
    CHECK(counts["/image"] == 0);
}

TEST_CASE("meshes and calibrations come at their pace, however many there are") {
    const auto queue = std::make_unique<EstimateQueue>();
    const test::TempDir dir;
    McapWriter writer(dir.file("estimates.mcap"), Compression::kNone, "", "test");
    EstimateChannels channels(writer);
    CHECK(queue->wants_calibration());
    CHECK_FALSE(queue->wants_picture({}, true));
    const FlightViewer::Fillers all = fillers();
    const FlightViewer::Fillers mesh{all.mesh, {}, {}};
    for (int k = 0; k < 100; ++k) {  // 5 s
        queue->offer(state_at(k), queue->wants_calibration() ? all : mesh);
        queue->pass_on(channels);
    }
    writer.close();
    std::map<std::string, int> counts = topics_of(dir.file("estimates.mcap"));
    CHECK(queue->dropped() == 0);
    CHECK(counts["/mesh"] == 10);
    CHECK(counts["/calibration"] >= 4);
    CHECK(counts["/calibration"] <= 6);
    CHECK(counts["/tf"] == 100 + 20);
}

}  // namespace
}  // namespace facet::estimate_queue_test
