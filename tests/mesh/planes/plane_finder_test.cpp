// SPDX-License-Identifier: BSD-2-Clause
// The plane finder behind the mesher, on made-up worlds with the noise of a stereo camera.
#include "mesh/planes/plane_finder.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

#include "tests/mesh/planes/plane_worlds.h"
#include "tests/support/allocation_guard.h"

namespace facet::plane_finder_test {
namespace {

using Eigen::Vector3d;
using test::Corner;
using test::find_like;
using test::kCorner;
using test::looking;
using test::most_planes;
using test::PlaneRig;
using test::PlaneWorld;

constexpr double kDegree = std::numbers::pi / 180.0;

const Se3 kFront = looking({1.0, 0.0, 1.2}, 0.0, 0.0);

int on_surface(const PlaneWorld& world, const PlaneProposal& p, int surface) {
    return static_cast<int>(std::count_if(p.landmarks.begin(), p.landmarks.end(),
                                          [&](LandmarkId id) { return world.points[id.value].surface == surface; }));
}

void require_sound(const PlaneProposals& proposals) {
    std::vector<LandmarkId> all;
    for (std::size_t i = 0; i < proposals.size(); ++i) {
        const PlaneProposal& p = proposals[i];
        REQUIRE(p.id.valid());
        REQUIRE((i == 0 || proposals[i - 1].id < p.id));
        REQUIRE(std::abs(p.normal_W.norm() - 1.0) < 1e-9);
        REQUIRE(p.landmarks.size() >= 3);
        REQUIRE(std::is_sorted(p.landmarks.begin(), p.landmarks.end()));
        all.insert(all.end(), p.landmarks.begin(), p.landmarks.end());
    }
    std::sort(all.begin(), all.end());
    REQUIRE(std::adjacent_find(all.begin(), all.end()) == all.end());  // none is on two planes
}

TEST_CASE("floor and walls of a room are found with their landmarks, and keep their ids") {
    const Corner world;
    PlaneRig rig(world);
    rig.hover(kCorner, 3);
    std::map<std::uint32_t, Vector3d> normals;
    for (const PlaneProposal& p : rig.finder->proposals()) {
        normals[p.id.value] = p.normal_W;
    }
    const PlaneProposals& proposals = rig.hover(kCorner, 8);
    require_sound(proposals);
    REQUIRE(proposals.size() == 3);
    const struct {
        Vector3d n;
        double d;
        int surface;
        PlaneKind kind;
    } truths[]{{Vector3d::UnitZ(), 0.0, world.floor, PlaneKind::kHorizontal},
               {-Vector3d::UnitX(), -4.0, world.front, PlaneKind::kVertical},
               {-Vector3d::UnitY(), -2.0, world.side, PlaneKind::kVertical}};
    for (const auto& truth : truths) {
        const PlaneProposal* p = find_like(proposals, truth.n);
        REQUIRE(p != nullptr);
        CHECK(p->kind == truth.kind);
        CHECK(std::acos(std::min(1.0, p->normal_W.dot(truth.n))) < 1.0 * kDegree);
        CHECK(std::abs(p->distance_m - truth.d) < 0.03);
        const int right = on_surface(world, *p, truth.surface);
        CHECK(right > 40);
        CHECK(right > 0.93 * static_cast<double>(p->landmarks.size()));  // where planes meet, points are near both
        REQUIRE(normals.count(p->id.value) == 1);
        CHECK(normals[p->id.value].dot(p->normal_W) > 0.99);
    }
    CHECK(rig.finder->counters().confirmed == 3);
}

TEST_CASE("slanted surfaces are found, one plane each, and not taken for level or upright ones") {
    for (const double degrees : {7.0, 10.0, 15.0, 25.0, 45.0, 70.0, 83.0}) {
        for (const double azimuth : {0.0, 25.0, -40.0}) {
            const double a = degrees * kDegree;
            const double b = azimuth * kDegree;
            const Vector3d uphill(std::cos(a) * std::cos(b), std::cos(a) * std::sin(b), std::sin(a));
            const Vector3d along(std::sin(b), -std::cos(b), 0.0);
            PlaneWorld world;
            world.add(Vector3d(3.0, 0.0, 1.0) - 1.5 * along - 1.5 * uphill, 3.0 * along, 3.0 * uphill, 0.2);
            const Vector3d normal = along.cross(uphill);
            INFO(degrees << " deg, " << azimuth << " deg");
            const Se3 camera = looking({0.0, 0.0, 1.8}, 0.0, 0.25);
            if (degrees < 80.0) {
                CHECK(most_planes(world, camera, 10, false) == 0);
            }
            PlaneRig rig(world);
            const PlaneProposals& proposals = rig.hover(camera, 10);
            require_sound(proposals);
            REQUIRE(proposals.size() == 1);
            CHECK(proposals[0].kind == PlaneKind::kSlanted);
            CHECK(std::acos(std::min(1.0, proposals[0].normal_W.dot(normal))) < 1.0 * kDegree);
            CHECK(std::abs(proposals[0].distance_m - normal.dot(Vector3d(3.0, 0.0, 1.0))) < 0.03);
        }
    }
}

TEST_CASE("at most eight level and upright candidates are examined at a keyframe, and four slanted ones") {
    PlaneWorld world;  // a rack of boards that the camera looks down on, small ones
    for (int i = 0; i < 14; ++i) {
        world.add({2.0, -1.4 + 0.2 * i, 0.06 * i}, {0.7, 0.0, 0.0}, {0.0, 0.19, 0.0}, 0.09);
    }
    for (int i = 0; i < 7; ++i) {  // and gables above them
        const double y = -1.4 + 0.4 * i;
        world.add({2.8, y + 0.19, 0.9}, {0.0, -0.19, 0.0}, {0.3 + 0.05 * i, 0.0, 0.7 - 0.05 * i}, 0.09);
        world.add({2.8, y + 0.39, 0.9}, {0.1, -0.15, 0.0}, {0.3 + 0.05 * i, 0.2, 0.7 - 0.05 * i}, 0.09);
    }
    PlaneConfig config;
    config.min_area_m2 = 0.035;
    PlaneRig rig(world, config);
    std::uint64_t before = 0;
    std::uint64_t most = 0;
    for (int k = 0; k < 8; ++k) {
        rig.hover(looking({0.0, 0.0, 1.6}, 0.0, 0.3), 1);
        most = std::max(most, rig.finder->counters().candidates - before);
        before = rig.finder->counters().candidates;
    }
    CHECK(most == 12);
}

TEST_CASE("a real floor with clutter on it is found, the clutter's landmarks are not on it") {
    PlaneWorld world;
    const int floor = world.add({1.0, -1.8, 0.0}, {3.5, 0.0, 0.0}, {0.0, 3.6, 0.0}, 0.2);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    for (int i = 0; i < 60; ++i) {
        world.add_point(
            {2.2 + 0.5 * uniform(world.random), 0.5 * uniform(world.random), 0.35 + 0.25 * uniform(world.random)});
    }
    PlaneRig rig(world);
    const PlaneProposals& proposals = rig.hover(looking({0.0, 0.0, 1.4}, 0.0, 0.4), 6);
    REQUIRE(proposals.size() == 1);
    CHECK(std::abs(proposals[0].distance_m) < 0.03);
    CHECK(on_surface(world, proposals[0], floor) > 0.98 * static_cast<double>(proposals[0].landmarks.size()));
}

TEST_CASE("what the estimator made of a plane is the plane, and landmarks are judged by it") {
    const Corner world;
    PlaneRig rig(world);
    const PlaneProposals& proposals = rig.hover(kCorner, 4);
    const PlaneProposal* floor = find_like(proposals, Vector3d::UnitZ());
    REQUIRE(floor != nullptr);
    PlaneEstimate estimate;
    estimate.id = floor->id;
    estimate.kind = floor->kind;
    estimate.normal_W = Vector3d(0.004, 0.0, 1.0).normalized();
    estimate.distance_m = floor->distance_m + 0.004;
    estimate.constraints = 50;
    rig.viewer.view(++rig.number, kCorner);
    rig.viewer.last().planes.push_back(estimate);
    rig.step_on(rig.viewer.last());
    floor = find_like(rig.finder->proposals(), Vector3d::UnitZ());
    REQUIRE(floor != nullptr);
    CHECK(floor->normal_W == estimate.normal_W);
    CHECK(floor->distance_m == estimate.distance_m);
    CHECK(floor->id == estimate.id);
    // An estimate that is far off loses its landmarks, and with them the plane.
    rig.viewer.view(++rig.number, kCorner);
    estimate.distance_m += 0.5;
    rig.viewer.last().planes.clear();
    rig.viewer.last().planes.push_back(estimate);
    rig.step_on(rig.viewer.last());
    for (const PlaneProposal& p : rig.finder->proposals()) {
        CHECK(p.id != estimate.id);
    }
}

TEST_CASE("the floor of the next room, a degree off, is another plane while the estimator knows the first") {
    PlaneWorld world;
    world.noise_px = 0.05;
    const int here = world.add({0.5, -1.5, 0.0}, {2.5, 0.0, 0.0}, {0.0, 3.0, 0.0}, 0.2);
    const double slope = std::tan(1.0 * kDegree);
    const int next = world.add({3.0, -1.5, 0.0}, {2.5, 0.0, 2.5 * slope}, {0.0, 3.0, 0.0}, 0.2);
    PlaneRig rig(world);
    rig.viewer.memory = 2;
    const Se3 first = looking({-0.3, 0.0, 1.3}, 0.0, 0.9);  // neither sees the other floor
    const Se3 second = looking({2.9, 0.0, 1.3}, 0.0, 0.9);
    rig.hover(first, 4);
    REQUIRE(rig.finder->proposals().size() == 1);
    const PlaneProposal floor = rig.finder->proposals()[0];
    REQUIRE(on_surface(world, floor, here) > 40);
    const auto look = [&](const Se3& from, int constraints) {
        rig.viewer.view(++rig.number, from);
        rig.viewer.last().planes.clear();
        rig.viewer.last().planes.push_back({floor.id, floor.kind, floor.normal_W, floor.distance_m, constraints});
        rig.step_on(rig.viewer.last());
    };
    look(first, 60);
    PlaneId other;
    for (int k = 0; k < 16; ++k) {
        look(second, 0);
        for (const PlaneProposal& p : rig.finder->proposals()) {
            if (on_surface(world, p, next) > 40) {
                CHECK(p.id != floor.id);
                CHECK((!other.valid() || p.id == other));
                other = p.id;
            }
        }
    }
    CHECK(other.valid());
}

TEST_CASE("the map moves, by drift taken out: planes move along under their ids") {
    const Corner world;
    PlaneRig rig(world);
    rig.hover(kCorner, 4);
    const auto before = rig.finder->proposals();
    rig.viewer.shift = {0.12, -0.09, 0.1};
    const PlaneProposals& after = rig.hover(kCorner, 1);
    REQUIRE(after.size() == 3);
    for (std::size_t i = 0; i < 3; ++i) {
        CHECK(after[i].id == before[i].id);
        CHECK(after[i].distance_m - before[i].distance_m ==
              Approx(before[i].normal_W.dot(rig.viewer.shift)).margin(0.01));
        CHECK(after[i].landmarks.size() > 0.9 * static_cast<double>(before[i].landmarks.size()));
    }
}

TEST_CASE("a plane left and found again has its old id; after a reset ids are new") {
    const Corner world;
    PlaneRig rig(world);
    rig.hover(kFront, 4);
    const PlaneProposal* wall = find_like(rig.finder->proposals(), -Vector3d::UnitX());
    REQUIRE(wall != nullptr);
    const PlaneId id = wall->id;
    const Se3 away = looking({1.0, 0.0, 1.2}, std::numbers::pi, 0.0);
    for (int k = 0; k < 25; ++k) {
        rig.step(away);
    }
    CHECK(rig.finder->proposals().empty());
    rig.hover(kFront, 3);
    wall = find_like(rig.finder->proposals(), -Vector3d::UnitX());
    REQUIRE(wall != nullptr);
    CHECK(wall->id == id);
    CHECK(rig.finder->counters().found_again >= 1);
    rig.finder->reset();
    CHECK(rig.finder->planes().empty());
    const PlaneProposals& fresh = rig.hover(kFront, 3);
    REQUIRE(find_like(fresh, -Vector3d::UnitX()) != nullptr);
    CHECK(find_like(fresh, -Vector3d::UnitX())->id > id);
}

TEST_CASE("a wall in line with one that has left, but metres away, is another one") {
    PlaneWorld world;
    world.add({3.0, 3.5, 0.0}, {0.0, -1.6, 0.0}, {0.0, 0.0, 2.2}, 0.2);
    world.add({3.0, -1.9, 0.0}, {0.0, -1.6, 0.0}, {0.0, 0.0, 2.2}, 0.2);
    PlaneRig rig(world);
    const Se3 left = looking({0.5, 2.7, 1.2}, 0.0, 0.0);
    const Se3 right = looking({0.5, -2.7, 1.2}, 0.0, 0.0);
    const Se3 away = looking({1.0, 0.0, 1.2}, std::numbers::pi, 0.0);
    const auto visit = [&](const Se3& view) {
        const PlaneProposals& proposals = rig.hover(view, 5);
        REQUIRE(proposals.size() == 1);
        const PlaneId id = proposals[0].id;
        for (int k = 0; k < 22; ++k) {
            rig.step(away);
        }
        return id;
    };
    const PlaneId first = visit(left);
    const PlaneId second = visit(right);
    CHECK(second > first);
    CHECK(visit(left) == first);
    CHECK(visit(right) == second);
    CHECK(rig.finder->counters().merged == 0);
}

TEST_CASE("two planes that become equal merge under the older id") {
    PlaneWorld world;  // one wall whose right part is first seen half a metre off, and moves into place
    const int left = world.add({3.0, 2.0, 0.0}, {0.0, -2.0, 0.0}, {0.0, 0.0, 2.2}, 0.2);
    const int right = world.add({3.5, 0.0, 0.0}, {0.0, -2.0, 0.0}, {0.0, 0.0, 2.2}, 0.2);
    world.noise_px = 0.1;  // of one surface chi-square would scatter about one with all that the covariance allows
    PlaneRig rig(world);
    const PlaneProposals& proposals = rig.hover(kFront, 5);
    REQUIRE(proposals.size() == 2);
    const PlaneId older = proposals[0].id;
    for (int step = 0; step < 25; ++step) {
        for (test::WorldPoint& p : world.points) {
            p.p.x() -= p.p.x() > 3.01 ? 0.02 : 0.0;
        }
        rig.hover(kFront, 1);
    }
    rig.hover(kFront, 2);
    REQUIRE(proposals.size() == 1);
    CHECK(proposals[0].id == older);
    CHECK(rig.finder->counters().merged == 1);
    CHECK(on_surface(world, proposals[0], left) > 60);
    CHECK(on_surface(world, proposals[0], right) > 60);
    rig.hover(kFront, 4);
    REQUIRE(proposals.size() == 1);
    CHECK(proposals[0].id == older);
}

TEST_CASE("a landmark that leaves the plane leaves the list; a little is forgiven to those on it") {
    PlaneWorld world;
    world.noise_px = 0.05;
    world.add({3.0, 1.5, 0.0}, {0.0, -3.0, 0.0}, {0.0, 0.0, 2.2}, 0.2);
    PlaneConfig config;
    config.surface_sigma_m = 0.03;
    PlaneRig rig(world, config);
    const PlaneProposals& proposals = rig.hover(kFront, 4);
    REQUIRE(proposals.size() == 1);
    const LandmarkId stays = proposals[0].landmarks[proposals[0].landmarks.size() / 2];
    const LandmarkId leaves = proposals[0].landmarks[proposals[0].landmarks.size() / 3];
    const auto is_on = [&](LandmarkId id) {
        return std::binary_search(proposals[0].landmarks.begin(), proposals[0].landmarks.end(), id);
    };
    world.points[stays.value].p.x() += 0.5 * (PlaneLimits::kJoin_m + PlaneLimits::kStay_m);
    world.points[leaves.value].p.x() += 1.3 * PlaneLimits::kStay_m;
    rig.hover(kFront, 1);
    CHECK(is_on(stays));
    CHECK_FALSE(is_on(leaves));
}

TEST_CASE("a wall with more landmarks than a plane takes keeps well spread ones, and the same ones") {
    PlaneWorld world;
    world.add({3.0, 1.8, 0.1}, {0.0, -3.6, 0.0}, {0.0, 0.0, 2.2}, 0.13);
    REQUIRE(world.points.size() > 400);
    PlaneRig rig(world);
    const PlaneProposals& proposals = rig.hover(kFront, 4);
    REQUIRE(proposals.size() == 1);
    REQUIRE(proposals[0].landmarks.size() == kMaxPlaneLandmarks);
    std::array<int, 12> cells{};
    for (const LandmarkId id : proposals[0].landmarks) {
        const Vector3d& p = world.points[id.value].p;
        const int u = std::clamp(static_cast<int>((p.y() + 1.6) / 0.8), 0, 3);
        const int v = std::clamp(static_cast<int>((p.z() - 0.3) / 0.6), 0, 2);
        ++cells[static_cast<std::size_t>(4 * v + u)];
    }
    CHECK(*std::min_element(cells.begin(), cells.end()) > 10);
    const std::vector<LandmarkId> before(proposals[0].landmarks.begin(), proposals[0].landmarks.end());
    rig.hover(kFront, 1);
    std::vector<LandmarkId> common;
    std::set_intersection(before.begin(), before.end(), proposals[0].landmarks.begin(), proposals[0].landmarks.end(),
                          std::back_inserter(common));
    CHECK(common.size() > 230);
}

TEST_CASE("more planes than there is room for: the first ones stay, the others wait until one is lost") {
    PlaneWorld world;  // panels around the camera, each nearer or farther than its neighbours
    world.noise_px = 0.12;
    constexpr int kPanels = 32;
    std::vector<Se3> views;
    for (int i = 0; i < kPanels; ++i) {
        const double yaw = 2.0 * std::numbers::pi * i / kPanels;
        const Vector3d out(std::cos(yaw), std::sin(yaw), 0.0);
        const Vector3d side(-std::sin(yaw), std::cos(yaw), 0.0);
        world.add((i % 2 == 0 ? 2.5 : 3.0) * out + 0.31 * side, -0.62 * side, {0.0, 0.0, 1.6}, 0.124);
        views.push_back(looking({0.0, 0.0, 0.8}, yaw, 0.0));
    }
    PlaneRig rig(world);
    rig.viewer.memory = 1000;
    for (int i = 0; i < kMaxPlanes + 3; ++i) {
        rig.hover(views[static_cast<std::size_t>(i)], 3);
    }
    const auto first = rig.finder->proposals();
    REQUIRE(first.size() == kMaxPlanes);
    for (int i = kMaxPlanes + 4; i < kPanels; ++i) {
        rig.hover(views[static_cast<std::size_t>(i)], 3);
        require_sound(rig.finder->proposals());
    }
    REQUIRE(rig.finder->proposals().size() == kMaxPlanes);
    for (std::size_t i = 0; i < kMaxPlanes; ++i) {
        CHECK(rig.finder->proposals()[i].id == first[i].id);
    }
    CHECK(rig.finder->counters().crowded_out > 0);
    rig.viewer.memory = 3;
    rig.hover(views[kPanels - 2], 14);
    REQUIRE(rig.finder->proposals().size() >= 1);
    CHECK(rig.finder->proposals()[rig.finder->proposals().size() - 1].id > first[kMaxPlanes - 1].id);
}

TEST_CASE("equal keyframes give equal planes, without a call to the heap") {
    const Corner world;
    PlaneRig a(world);
    PlaneRig b(world);
    std::uint64_t allocations = 0;
    for (int k = 0; k < 6; ++k) {
        const KeyframeView& view = a.viewer.view(k + 1, kCorner);
        a.mesher->update(view, {});
        b.mesher->update(view, {});
        const test::AllocationGuard guard;
        a.finder->update(a.mesher->mesh(), view);
        a.finder->label(a.mesher->mesh());
        allocations += guard.allocations();
        b.finder->update(b.mesher->mesh(), view);
        REQUIRE(a.finder->proposals().size() == b.finder->proposals().size());
        for (std::size_t i = 0; i < a.finder->proposals().size(); ++i) {
            const PlaneProposal& p = a.finder->proposals()[i];
            const PlaneProposal& q = b.finder->proposals()[i];
            REQUIRE(p.id == q.id);
            REQUIRE(p.normal_W == q.normal_W);
            REQUIRE(p.distance_m == q.distance_m);
            REQUIRE(std::equal(p.landmarks.begin(), p.landmarks.end(), q.landmarks.begin(), q.landmarks.end()));
        }
    }
    CHECK(a.finder->proposals().size() == 3);
    CHECK(allocations == 0);
}

TEST_CASE("an empty view and an empty mesh give no planes; parameters out of range are refused") {
    const auto finder = std::make_unique<PlaneFinder>();
    REQUIRE(ok(finder->configure({})));
    const auto view = std::make_unique<KeyframeView>();
    view->number = 1;
    CHECK(finder->update(*std::make_unique<HorizonMesh>(), *view).empty());
    PlaneConfig config;
    config.min_area_m2 = -1.0;
    CHECK(finder->configure(config) == Status::kInvalidArgument);
}

}  // namespace
}  // namespace facet::plane_finder_test
