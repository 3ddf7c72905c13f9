// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/depth/semi_dense_depth.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <vector>

#include "mesh/occupancy_grid.h"
#include "tests/mesh/depth/stereo_scene.h"
#include "tests/support/allocation_guard.h"

namespace facet::semi_dense_depth_test {
namespace {

using test::ScenePair;

/// Depth behind a mesher that knows nothing yet.
struct Stage {
    std::unique_ptr<SemiDenseDepth> depth = std::make_unique<SemiDenseDepth>();
    std::unique_ptr<Mesher> mesher = std::make_unique<Mesher>();
    std::unique_ptr<KeyframeView> view = std::make_unique<KeyframeView>();

    Stage() {
        REQUIRE(ok(mesher->configure({}, test::scene_rig().left)));
        REQUIRE(ok(depth->configure(test::scene_rig(), 8, 300)));
        view->T_W_C0 = test::looking_along_x({0.05, 0.05, 0.05});
    }
    std::vector<DepthPoint> points(const ScenePair& pair, int slices = 100) {
        depth->begin(*view, pair.left.view(), pair.right.view());
        for (int i = 0; i < slices && depth->is_busy(); ++i) {
            depth->advance(*mesher);
        }
        const auto taken = depth->take();
        return {taken.begin(), taken.end()};
    }
};

TEST_CASE("a keyframe's points lie on its surface, in the world, without heap") {
    const ScenePair pair(test::plane_surface(Eigen::Vector3d::UnitZ(), 2.0));
    Stage stage;
    stage.depth->begin(*stage.view, pair.left.view(), pair.right.view());
    int slices = 0;
    const test::AllocationGuard guard;
    while (stage.depth->is_busy()) {
        stage.depth->advance(*stage.mesher);
        ++slices;
    }
    const auto points = stage.depth->take();
    const std::uint64_t allocations = guard.allocations();
    CHECK(allocations == 0);
    CHECK(slices == 4);  // 40 x 30 squares, 300 a slice
    CHECK(points.size() > 500);
    for (const DepthPoint& p : points) {
        CHECK(std::abs(p.p_W.x() - 2.05) < 4.0 * p.sigma_m);
        CHECK(p.sigma_m < 0.25);
    }
    CHECK(stage.depth->take().empty());
}

TEST_CASE("what is there when the next keyframe comes covers all of the view, and does not depend on chance") {
    const ScenePair pair(test::plane_surface(Eigen::Vector3d::UnitZ(), 2.0));
    Stage stage;
    const auto part = stage.points(pair, 2);
    CHECK(stage.depth->counters().unfinished == 1);
    const auto whole = stage.points(pair);
    CHECK(stage.depth->counters().unfinished == 1);
    CHECK(stage.depth->counters().keyframes == 2);
    std::array<int, 4> quarters{};
    for (const DepthPoint& p : part) {
        ++quarters[(p.p_W.y() > 0.05 ? 1U : 0U) + (p.p_W.z() > 0.05 ? 2U : 0U)];
    }
    for (const int count : quarters) {
        CHECK(count > 0.1 * static_cast<double>(part.size()));
    }
    CHECK(part.size() > whole.size() / 4);
    Stage other;
    const auto again = other.points(pair);
    REQUIRE(again.size() == whole.size());
    for (std::size_t i = 0; i < again.size(); ++i) {
        CHECK(again[i].p_W == whole[i].p_W);
    }
}

TEST_CASE("a match with which no neighbour agrees is left out") {
    const ScenePair pair(test::step_surface(1.5, 3.0));
    Stage stage;
    const std::size_t points = stage.points(pair).size();
    const DepthCounters& counters = stage.depth->counters();
    CHECK(counters.lonely > 0);
    CHECK(counters.verdicts[static_cast<std::size_t>(DepthVerdict::kMatched)] == points + counters.lonely);
}

TEST_CASE("without a right image, and with exchanged cameras, there are no points") {
    const ScenePair pair(test::plane_surface(Eigen::Vector3d::UnitZ(), 2.0));
    Stage stage;
    stage.depth->begin(*stage.view, pair.left.view(), {});
    CHECK(!stage.depth->is_busy());
    CHECK(stage.depth->take().empty());
    stage.view->is_exchanged = true;
    CHECK(stage.points(pair).empty());
}

TEST_CASE("two keyframes of points make free space and an obstacle, one makes neither") {
    const ScenePair pair(test::plane_surface(Eigen::Vector3d::UnitZ(), 1.2, 0.03));
    Stage stage;
    const auto grid = std::make_unique<OccupancyGrid>();
    const HorizonMesh nothing;
    for (int k = 0; k < 2; ++k) {
        stage.view->stamp = {1'000'000'000LL * (k + 1)};
        grid->update(*stage.view, nothing, static_cast<std::uint32_t>(k + 1));
        const auto points = stage.points(pair);
        const test::AllocationGuard guard;
        grid->add_depth({points.data(), points.size()});
        const std::uint64_t allocations = guard.allocations();
        CHECK(allocations == 0);
        const Eigen::Vector3d eye = stage.view->T_W_C0.p;
        int free = 0;
        int walls = 0;
        for (int i = -10; i <= 10; ++i) {
            const Eigen::Vector3d direction(1.2, 0.03 * i, 0.02 * i);
            const GridRay ray = grid->cast(eye, direction, 5.0);
            free += ray.free_m > 0.95 ? 1 : 0;
            // A ray may pass between the points, whose cells are the wall; none may come out behind it.
            walls += grid->segment(eye, eye + 1.1 * direction, 0.0).space == Space::kOccupied ? 1 : 0;
            CHECK(ray.free_m < 1.05 * direction.norm());
            CHECK(ray.end.space != Space::kFree);
        }
        CAPTURE(k, free, walls);
        CHECK(free >= (k == 0 ? 0 : 18));
        CHECK(free <= (k == 0 ? 0 : 21));
        CHECK(walls >= (k == 0 ? 0 : 18));
        CHECK(walls <= (k == 0 ? 0 : 21));
    }
}

}  // namespace
}  // namespace facet::semi_dense_depth_test
