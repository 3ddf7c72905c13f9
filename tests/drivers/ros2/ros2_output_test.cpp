// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/ros2/ros2_output.h"

#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <cstring>
#include <string>
#include <thread>

#include "drivers/ros2/odometry_message.h"
#include "tests/drivers/ros2/fake_ros2.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/scripted_source.h"

namespace facet::ros2_output_test {
namespace {

constexpr Duration kOffset = Duration::from_seconds(1.7e9);

Odometry some_odometry() {
    Odometry odometry;
    odometry.stamp = {5'000'000'000};
    odometry.q_W_B = Eigen::AngleAxisd(M_PI / 2.0, Eigen::Vector3d::UnitZ());
    odometry.p_W_B = {1.0, 2.0, 3.0};
    odometry.v_W_B = {0.0, 4.0, 0.5};  // forwards, for a body that looks along y
    odometry.w_B = {0.1, 0.2, 0.3};
    odometry.pose_covariance.diagonal() << 1.0, 2.0, 3.0, 4.0, 5.0, 6.0;
    odometry.pose_covariance(0, 3) = odometry.pose_covariance(3, 0) = 0.5;
    odometry.v_covariance.diagonal() << 7.0, 8.0, 9.0;
    odometry.w_covariance.diagonal() << 10.0, 11.0, 12.0;
    odometry.quality = 80;
    return odometry;
}

TEST_CASE("odometry has the twist in the body, and turns about the world's axes") {
    const Ros2Odometry m = to_ros2(some_odometry(), {42});
    CHECK(m.stamp == Timestamp{42});
    CHECK(m.p == Eigen::Vector3d(1.0, 2.0, 3.0));
    CHECK(m.v_B.isApprox(Eigen::Vector3d(4.0, 0.0, 0.5), 1e-12));
    CHECK(m.w_B == Eigen::Vector3d(0.1, 0.2, 0.3));
    const auto pose = [&](std::size_t row, std::size_t column) { return m.pose_covariance[6 * row + column]; };
    const auto twist = [&](std::size_t row, std::size_t column) { return m.twist_covariance[6 * row + column]; };
    CHECK(pose(0, 0) == 1.0);
    CHECK(pose(3, 3) == Approx(5.0));  // the body's y is the world's -x
    CHECK(pose(4, 4) == Approx(4.0));
    CHECK(pose(5, 5) == Approx(6.0));
    CHECK(pose(0, 4) == Approx(0.5));  // the body's x is the world's y
    CHECK(pose(4, 0) == Approx(0.5));
    CHECK(std::abs(pose(0, 3)) < 1e-12);
    CHECK(twist(0, 0) == Approx(8.0));
    CHECK(twist(1, 1) == Approx(7.0));
    CHECK(twist(3, 3) == 10.0);
    CHECK(twist(0, 3) == 0.0);
}

/// An output whose thread runs for the time of a test.
struct Scene {
    explicit Scene(Ros2SceneSource* source = nullptr) {
        output.show(source);
        std::string problem;
        REQUIRE(ok(output.open(problem)));
    }
    ManualClock clock{{6'000'000'000}, kOffset};
    test::FakeNode node;
    Ros2Output output{node, clock, {}};
};

TEST_CASE("poses are published with stamps of the wall clock, and sending them uses no heap") {
    Scene s;
    const Odometry odometry = some_odometry();
    {
        const test::AllocationGuard guard;
        const Status sent = s.output.send(odometry);
        const std::uint64_t allocations = guard.allocations();
        CHECK(allocations == 0);
        CHECK(ok(sent));
    }
    s.output.close();
    REQUIRE(s.node.graph.odometry.size() == 1);
    CHECK(s.node.graph.odometry[0].stamp == Timestamp{5'000'000'000} + kOffset);
    CHECK(s.output.counters().poses == 1);
}

TEST_CASE("a pose that says nothing is refused") {
    Scene s;
    Odometry nan = some_odometry();
    nan.p_W_B.x() = std::nan("");
    CHECK(s.output.send(nan) == Status::kInvalidArgument);
    Odometry certain = some_odometry();
    certain.pose_covariance(2, 2) = 0.0;
    CHECK(s.output.send(certain) == Status::kInvalidArgument);
    s.output.close();
    CHECK(s.node.graph.odometry.empty());
}

TEST_CASE("a lost estimator publishes diagnostics and no poses") {
    Scene s;
    StateChange change;
    change.state = SinkState::kLost;
    std::strcpy(change.text.data(), "facet: LOST no_images");
    s.output.report(change);
    Odometry lost = some_odometry();
    lost.state = SinkState::kLost;
    lost.quality = -1;
    lost.stamp = s.clock.now();
    REQUIRE(ok(s.output.send(lost)));
    s.output.close();
    CHECK(s.node.graph.odometry.empty());
    CHECK(s.output.counters().lost == 1);
    REQUIRE_FALSE(s.node.graph.diagnostics.empty());
    const Ros2Diagnostic& last = s.node.graph.diagnostics.back();
    CHECK(last.level == Ros2Diagnostic::Level::kError);
    CHECK(last.message == "facet: LOST no_images");
}

TEST_CASE("what the middleware has no room for is dropped and counted") {
    Scene s;
    s.node.graph.is_full = true;
    REQUIRE(ok(s.output.send(some_odometry())));
    s.output.close();
    CHECK(s.output.counters().poses == 0);
    CHECK(s.output.counters().dropped == 1);
}

TEST_CASE("an output that cannot be opened says why") {
    test::FakeNode node;
    node.graph.is_broken = true;
    const ManualClock clock;
    Ros2Output output(node, clock, {});
    std::string problem;
    CHECK(output.open(problem) == Status::kIo);
    CHECK(problem == "the graph is broken");
    output.close();
}

/// Gives one scene, as far as it is wished for.
class OneScene final : public Ros2SceneSource {
public:
    bool take(const Ros2Wishes& wishes, Ros2Scene& scene) override {
        if (is_taken_.exchange(true)) {
            return false;
        }
        CHECK(scene.mesh.empty());
        scene.has_mesh = wishes.mesh;
        scene.mesh.resize(3);
        scene.planes.resize(2);
        scene.has_landmarks = wishes.landmarks;
        scene.landmarks.resize(5);
        scene.has_path = wishes.path;
        scene.path.resize(4);
        scene.has_grid = wishes.grid;
        scene.grid.cells.resize(6);
        scene.has_map = true;
        scene.map.p = {1.0, 2.0, 3.0};
        return true;
    }
    bool is_taken() const { return is_taken_; }

private:
    std::atomic<bool> is_taken_{false};
};

TEST_CASE("mesh, planes, landmarks, path and grid are published to who listens") {
    OneScene scene;
    Scene s(&scene);
    while (!scene.is_taken()) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    s.output.close();
    using Kept = std::pair<Ros2Topic, std::size_t>;
    CHECK(s.node.graph.scenes == std::vector<Kept>{{Ros2Topic::kMesh, 3},
                                                   {Ros2Topic::kPlanes, 2},
                                                   {Ros2Topic::kLandmarks, 5},
                                                   {Ros2Topic::kPath, 4},
                                                   {Ros2Topic::kGrid, 6}});
    CHECK(s.output.counters().scenes == 5);
    REQUIRE(s.node.graph.maps.size() == 1);
    CHECK(s.node.graph.maps[0].p == Eigen::Vector3d(1.0, 2.0, 3.0));
}

}  // namespace
}  // namespace facet::ros2_output_test
