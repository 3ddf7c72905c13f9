// SPDX-License-Identifier: BSD-2-Clause
// Planes seen again after a drift whose covariance is known.
#include "mesh/planes/plane_memory.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "tests/mesh/planes/plane_worlds.h"
#include "tests/support/allocation_guard.h"

namespace facet::plane_memory_test {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector3d;
using Eigen::Vector4d;
using test::Corner;
using test::find_like;
using test::kCorner;
using test::looking;
using test::PlaneRig;

// Keyframes after which a plane that is not found has left, those included in which the mesh still has its faces.
constexpr int kLongGone = PlaneLimits::kLeaveKeyframes + PlaneLimits::kForgetKeyframes + 40;

/// Turn about the vertical through `at`, then a shift.
struct Drift {
    Vector3d at = Vector3d::Zero();
    Vector4d error = Vector4d::Zero();

    Vector3d turned(const Vector3d& v) const { return Eigen::AngleAxisd(error(0), Vector3d::UnitZ()) * v; }
    Vector3d moved(const Vector3d& p) const { return at + turned(p - at) + error.tail<3>(); }
};

PlaneFit wall_at(const Vector3d& centroid, const Vector3d& normal) {
    PlaneFit fit;
    fit.normal_W = normal.normalized();
    fit.centroid_W = centroid;
    fit.distance_m = fit.normal_W.dot(centroid);
    fit.along_W = std::abs(fit.normal_W.z()) > 0.9 ? fit.normal_W.unitOrthogonal()
                                                   : Vector3d::UnitZ().cross(fit.normal_W).normalized();
    fit.across_W = fit.normal_W.cross(fit.along_W);
    fit.sigma_m = 0.004;
    fit.sigma_along_rad = 0.003;
    fit.sigma_across_rad = 0.004;
    fit.extent_along_m = 1.2;
    fit.extent_across_m = 0.6;
    return fit;
}

SeenPlane seen(const PlaneFit& fit, std::uint32_t id = 0, const SightedFrom& from = {}) {
    SeenPlane plane;
    plane.id = PlaneId{id};
    plane.kind = std::abs(fit.normal_W.z()) > 0.5 ? PlaneKind::kHorizontal : PlaneKind::kVertical;
    plane.fit = fit;
    plane.reach.extend(fit);
    plane.from = from;
    return plane;
}

/// The id under which a plane is recalled; invalid if it is not.
PlaneId recalled(PlaneMemory& memory, const SeenPlane& plane) {
    SeenPlane out;
    return ok(memory.recall(plane, out)) ? out.id : PlaneId{};
}

/// The plane as a drifted vehicle sees it, with an error of its own.
PlaneFit drifted(const PlaneFit& fit, const Drift& drift, const Vector3d& own) {
    PlaneFit out = fit;
    out.along_W = drift.turned(fit.along_W);
    out.across_W = drift.turned(fit.across_W);
    out.normal_W = (drift.turned(fit.normal_W) - own(1) * out.along_W - own(2) * out.across_W).normalized();
    out.along_W = (out.along_W - out.normal_W * out.normal_W.dot(out.along_W)).normalized();
    out.across_W = out.normal_W.cross(out.along_W);
    out.centroid_W = drift.moved(fit.centroid_W) + own(0) * out.normal_W;
    out.distance_m = out.normal_W.dot(out.centroid_W);
    return out;
}

class Gauss {
public:
    template <int kN>
    Eigen::Matrix<double, kN, 1> draw() {
        return Eigen::Matrix<double, kN, 1>::NullaryExpr([this] { return normal_(generator_); });
    }

private:
    std::mt19937 generator_{5};
    std::normal_distribution<double> normal_;
};

/// Heading and place after a way of `step`: the place follows the heading, and both gain.
Matrix4d carried(const Matrix4d& covariance, const Vector3d& step, const Matrix4d& gained) {
    Matrix4d f = Matrix4d::Identity();
    f.block<3, 1>(1, 0) = Vector3d::UnitZ().cross(step);
    return f * covariance * f.transpose() + gained;
}

TEST_CASE("the distance of a plane from itself after a drift is distributed as chi-square") {
    const Vector3d first(2.0, 1.0, 1.0);
    const Vector3d second(4.0, -6.0, 1.5);
    Matrix4d then = Vector4d(0.01, 0.05, 0.04, 0.02).cwiseAbs2().asDiagonal();
    then(0, 1) = then(1, 0) = 0.6 * 0.01 * 0.05;
    Matrix4d gained = Vector4d(0.02, 0.08, 0.12, 0.05).cwiseAbs2().asDiagonal();
    gained(0, 2) = gained(2, 0) = -0.5 * 0.02 * 0.12;
    const Matrix4d now = carried(then, second - first, gained);
    const Matrix4d root = gained.llt().matrixL();
    PlaneFit fit = wall_at({5.0, -4.0, 1.2}, {-1.0, 0.4, 0.0});
    fit.sigma_m = 0.03;  // far above what any two parts of a surface may differ by
    fit.sigma_along_rad = 0.04;
    fit.sigma_across_rad = 0.05;
    const Vector3d sigma(fit.sigma_m, fit.sigma_along_rad, fit.sigma_across_rad);
    Gauss gauss;
    constexpr int kDraws = 4000;
    double sum = 0.0;
    int beyond = 0;
    for (int i = 0; i < kDraws; ++i) {
        // What was off then is off now as well; only what came in between tells the planes apart.
        const PlaneFit before = drifted(fit, {}, sigma.cwiseProduct(gauss.draw<3>()));
        const PlaneFit after = drifted(fit, {second, root * gauss.draw<4>()}, sigma.cwiseProduct(gauss.draw<3>()));
        const double d = PlaneMemory::distance(seen(before, 1, {first, then}), seen(after, 2, {second, now}));
        sum += std::isfinite(d) ? d : 0.0;
        beyond += d > 11.34 ? 1 : 0;  // 1 %
    }
    CHECK(sum / kDraws == Approx(3.0).epsilon(0.1));
    CHECK(beyond < 0.02 * kDraws);
    CHECK(beyond > 0.002 * kDraws);
}

TEST_CASE("near the limit a plane is recalled as slanted or as level, but a floor never as a wall") {
    PlaneMemory memory;
    SeenPlane ramp = seen(wall_at({0.0, 0.0, 1.0}, Vector3d(std::sin(0.055), 0.0, std::cos(0.055))), 7);
    ramp.kind = PlaneKind::kSlanted;
    memory.keep(ramp);
    SeenPlane again = ramp;
    again.kind = PlaneKind::kVertical;
    ramp.kind = PlaneKind::kHorizontal;
    memory.keep(ramp);
    CHECK_FALSE(recalled(memory, again).valid());
    again.kind = PlaneKind::kSlanted;
    CHECK(recalled(memory, again) == PlaneId{7});
}

TEST_CASE("a plane is recalled within the drift that its covariance allows, once") {
    const SeenPlane plane = seen(wall_at({4.0, 0.0, 1.0}, {-1.0, 0.0, 0.0}), 7);
    const PlaneFit off = drifted(plane.fit, {Vector3d::Zero(), {0.0, 0.2, 0.0, 0.0}}, Vector3d::Zero());
    SightedFrom sure;
    SightedFrom unsure;
    unsure.covariance.diagonal() << 1e-4, 0.01, 0.01, 0.01;
    PlaneMemory memory;
    memory.keep(plane);
    CHECK_FALSE(recalled(memory, seen(off, 0, sure)).valid());
    CHECK(memory.size() == 1);
    CHECK(recalled(memory, seen(off, 0, unsure)) == PlaneId{7});
    CHECK(memory.size() == 0);
    CHECK_FALSE(recalled(memory, seen(off, 0, unsure)).valid());
    // What was as uncertain when it left says nothing about the drift since.
    SeenPlane uncertain_then = plane;
    uncertain_then.from = unsure;
    memory.keep(uncertain_then);
    CHECK_FALSE(recalled(memory, seen(off, 0, unsure)).valid());
}

TEST_CASE("planes that face away, are of another kind, lie elsewhere or may be one of two are not recalled") {
    SightedFrom unsure;
    unsure.covariance.diagonal() << 1e-4, 0.01, 0.01, 0.01;
    PlaneMemory memory;
    memory.keep(seen(wall_at({4.0, 0.0, 1.0}, {-1.0, 0.0, 0.0}), 1));
    CHECK_FALSE(recalled(memory, seen(wall_at({4.1, 0.0, 1.0}, {1.0, 0.0, 0.0}), 0, unsure)).valid());
    CHECK_FALSE(recalled(memory, seen(wall_at({4.0, 0.0, 1.0}, {0.0, 0.0, 1.0}), 0, unsure)).valid());
    CHECK_FALSE(recalled(memory, seen(wall_at({4.0, 12.0, 1.0}, {-1.0, 0.0, 0.0}), 0, unsure)).valid());
    memory.keep(seen(wall_at({4.15, 0.0, 1.0}, {-1.0, 0.0, 0.0}), 2));  // the door of a shelf before the wall
    CHECK_FALSE(recalled(memory, seen(wall_at({4.05, 0.0, 1.0}, {-1.0, 0.0, 0.0}), 0, unsure)).valid());
    CHECK(memory.size() == 2);
    CHECK(recalled(memory, seen(wall_at({4.0, 0.0, 1.0}, {-1.0, 0.0, 0.0}))) == PlaneId{1});  // who knows, knows
}

TEST_CASE("of planes that look alike, one where the plane is seen outweighs one beside it") {
    SightedFrom unsure;
    unsure.covariance.diagonal() << 1e-4, 0.01, 0.01, 0.01;
    const SeenPlane here = seen(wall_at({4.05, 0.3, 1.0}, {-1.0, 0.0, 0.0}), 0, unsure);
    PlaneMemory memory;
    memory.keep(seen(wall_at({4.0, 4.0, 1.0}, {-1.0, 0.0, 0.0}), 1));  // the wall of the next room
    SeenPlane out;
    CHECK(memory.recall_there(here, out) == Status::kNotFound);
    memory.keep(seen(wall_at({4.0, 0.0, 1.0}, {-1.0, 0.0, 0.0}), 2));
    REQUIRE(ok(memory.recall_there(here, out)));
    CHECK(out.id == PlaneId{2});
    memory.keep(out);
    CHECK(recalled(memory, here) == PlaneId{2});
    CHECK(recalled(memory, here) == PlaneId{1});  // where there is no other, it may be the end of that one
}

TEST_CASE("when the memory is full the plane that left first is forgotten; one that left again is known once") {
    PlaneMemory memory;
    const auto place = [](std::uint32_t i) { return Vector3d(10.0 * i, 0.0, 1.0); };
    for (std::uint32_t i = 0; i <= PlaneMemory::kCapacity; ++i) {
        memory.keep(seen(wall_at(place(i), {-1.0, 0.0, 0.0}), i));
        memory.keep(seen(wall_at(place(i), {-1.0, 0.0, 0.0}), i));
    }
    CHECK(memory.size() == PlaneMemory::kCapacity);
    CHECK_FALSE(recalled(memory, seen(wall_at(place(0), {-1.0, 0.0, 0.0}))).valid());
    const test::AllocationGuard guard;
    CHECK(recalled(memory, seen(wall_at(place(1), {-1.0, 0.0, 0.0}))) == PlaneId{1});
    memory.clear();
    CHECK(guard.allocations() == 0);
    CHECK(memory.size() == 0);
}

TEST_CASE("the finder gives planes their old ids after minutes and a drift, if the drift is known") {
    const bool knows = GENERATE(true, false);
    const Corner world;
    PlaneRig rig(world);
    rig.hover(kCorner, 4);
    const std::vector<TrackedPlane> before(rig.finder->planes().begin(), rig.finder->planes().end());
    REQUIRE(before.size() == 3);
    for (int k = 0; k < kLongGone; ++k) {
        rig.step(looking({0.0, 0.0, 1.3}, 3.0, 0.0));  // nothing is there
    }
    CHECK(rig.finder->planes().empty());
    rig.viewer.shift = {0.15, -0.12, 0.1};
    if (knows) {
        rig.viewer.last().heading_and_place.diagonal() << 1e-6, 0.01, 0.01, 0.01;
    }
    rig.hover(kCorner, 6);
    const auto after = rig.finder->planes();
    REQUIRE(after.size() == 3);
    for (const TrackedPlane& plane : before) {
        const auto again = std::find_if(after.begin(), after.end(), [&](const TrackedPlane& p) {
            return p.fit.normal_W.dot(plane.fit.normal_W) > 0.95;
        });
        REQUIRE(again != after.end());
        CHECK((again->id == plane.id) == knows);
        CHECK((again->proposed == plane.proposed) == knows);                   // to the estimator, too
        CHECK(std::abs(again->fit.distance_m - plane.fit.distance_m) > 0.05);  // the id comes back, not the place
    }
    CHECK(rig.finder->counters().recalled == (knows ? 3 : 0));
    CHECK(rig.finder->counters().confirmed == 6);
}

TEST_CASE("a plane that comes back off its place while it is followed still is that plane from then on") {
    const Corner world;
    PlaneRig rig(world);
    rig.hover(kCorner, 4);
    REQUIRE(rig.finder->planes().size() == 3);
    for (int k = 0; k < 20; ++k) {
        rig.step(looking({0.0, 0.0, 1.3}, 3.0, 0.0));  // nothing is there; the planes are followed
    }
    rig.viewer.shift = {0.15, -0.12, 0.1};
    rig.viewer.last().heading_and_place.diagonal() << 1e-6, 0.01, 0.01, 0.01;
    rig.hover(kCorner, 6);
    REQUIRE(rig.finder->counters().recalled == 3);
    REQUIRE(rig.finder->planes().size() == 3);
    for (const TrackedPlane& plane : rig.finder->planes()) {
        CHECK(plane.id.value < 3);
        CHECK(plane.proposed == plane.id);
    }
    rig.viewer.shift.setZero();  // the drift is taken out
    rig.hover(kCorner, 3);
    CHECK(rig.finder->counters().merged == 0);
    CHECK(rig.finder->planes().size() == 3);
}

TEST_CASE("a plane that was too far off to be known is known when it leaves, once the drift has been taken out") {
    const Corner world;
    PlaneRig rig(world);
    std::vector<std::pair<std::uint32_t, std::uint32_t>> merges;
    const auto leave = [&] {
        for (int k = 0; k < kLongGone; ++k) {
            rig.step(looking({0.0, 0.0, 1.3}, 3.0, 0.0));  // nothing is there
            for (const PlaneMerge& merge : rig.finder->merges()) {
                merges.emplace_back(merge.gone.value, merge.stays.value);
            }
        }
    };
    rig.hover(kCorner, 4);
    leave();
    rig.viewer.shift = {0.15, -0.12, 0.1};  // more than is claimed
    rig.hover(kCorner, 6);
    REQUIRE(rig.finder->counters().recalled == 0);
    REQUIRE(rig.finder->counters().confirmed == 6);
    rig.viewer.shift.setZero();
    rig.hover(kCorner, 6);
    REQUIRE(rig.finder->counters().confirmed == 6);
    CHECK(merges.empty());
    leave();
    REQUIRE(merges.size() == 3);
    for (const auto& [gone, stays] : merges) {
        CHECK(gone >= 3);
        CHECK(stays < 3);
    }
    CHECK(rig.finder->counters().merged == 3);
    rig.hover(kCorner, 6);
    CHECK(rig.finder->counters().recalled == 3);
    REQUIRE(rig.finder->planes().size() == 3);
    for (const TrackedPlane& plane : rig.finder->planes()) {
        CHECK(plane.id.value < 3);
        CHECK(plane.proposed.value >= 3);  // what the estimator has seen last: it may have forgotten the others
    }
}

TEST_CASE("a plane given up because its landmarks formed none any more is known when they do again") {
    Corner world;
    PlaneRig rig(world);
    rig.hover(kCorner, 4);
    const PlaneProposal* wall = find_like(rig.finder->proposals(), -Vector3d::UnitX());
    REQUIRE(wall != nullptr);
    const PlaneId proposed = wall->id;
    const auto bend = [&](double height_m) {
        for (test::WorldPoint& p : world.points) {
            p.p.x() += p.surface == world.front ? height_m * std::cos(1.5 * p.p.y()) : 0.0;
        }
    };
    bend(0.05);
    rig.hover(kCorner, 10);
    REQUIRE(rig.finder->counters().doubted == 1);
    bend(-0.05);
    rig.hover(kCorner, 6);
    wall = find_like(rig.finder->proposals(), -Vector3d::UnitX());
    REQUIRE(wall != nullptr);
    CHECK(wall->id == proposed);
    const auto planes = rig.finder->planes();
    const auto again =
        std::find_if(planes.begin(), planes.end(), [&](const TrackedPlane& p) { return p.proposed == wall->id; });
    REQUIRE(again != planes.end());
    CHECK(again->id == proposed);
}

}  // namespace
}  // namespace facet::plane_memory_test
