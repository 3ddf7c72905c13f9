// SPDX-License-Identifier: BSD-2-Clause
// How far planes reach, and how much of them is in the same place.
#include "mesh/planes/plane_reach.h"

#include <catch2/catch.hpp>
#include <cmath>

namespace facet::plane_reach_test {
namespace {

using Eigen::Vector3d;

/// An evenly covered piece of a wall that stands askew in the world: along the wall and up.
PlaneFit piece(double along_m, double up_m, double width_m, double height_m, double turn_rad = 0.0) {
    PlaneFit fit;
    fit.normal_W = Vector3d(-std::cos(0.7 + turn_rad), std::sin(0.7 + turn_rad), 0.0);
    fit.along_W = Vector3d::UnitZ().cross(fit.normal_W);
    fit.across_W = Vector3d::UnitZ();
    fit.centroid_W = Vector3d(3.0, 1.0, 1.0) + along_m * fit.along_W + up_m * fit.across_W;
    fit.distance_m = fit.normal_W.dot(fit.centroid_W);
    fit.extent_along_m = width_m / std::sqrt(12.0);
    fit.extent_across_m = height_m / std::sqrt(12.0);
    return fit;
}

PlaneReach reach_of(const PlaneFit& fit) {
    PlaneReach reach;
    reach.extend(fit);
    return reach;
}

TEST_CASE("pieces of a wall are apart by the gap between them, whichever way the wall stands") {
    const PlaneReach wall = reach_of(piece(0.0, 0.0, 4.0, 2.0));
    const PlaneReach next = reach_of(piece(3.5, 0.2, 2.0, 2.0));  // boxes along the world's axes would overlap
    CHECK(wall.distance(next) == Approx(0.5));
    CHECK(next.distance(wall) == Approx(0.5));
    CHECK(wall.overlap(next) == 0.0);
    CHECK(wall.distance(reach_of(piece(1.0, 0.3, 1.0, 1.0))) == 0.0);
    // As another sighting has it, a degree apart.
    CHECK(wall.distance(reach_of(piece(3.5, 0.2, 2.0, 2.0, 0.017))) == Approx(0.5).margin(0.01));
}

TEST_CASE("what overlaps is counted by the smaller piece") {
    const PlaneReach wall = reach_of(piece(0.0, 0.0, 4.0, 2.0));
    CHECK(wall.overlap(wall) == Approx(1.0));
    const PlaneReach inside = reach_of(piece(1.0, 0.2, 1.0, 0.5));
    CHECK(wall.overlap(inside) == Approx(1.0));
    CHECK(inside.overlap(wall) == Approx(1.0));
    CHECK(wall.overlap(reach_of(piece(2.0, 0.0, 2.0, 2.0))) == Approx(0.5));
    PlaneReach grown = wall;
    grown.extend(piece(3.0, 0.0, 2.0, 1.0));
    CHECK(grown.overlap(reach_of(piece(2.5, 0.0, 2.0, 2.0))) == Approx(1.0));
    grown = inside;
    grown.extend(wall);
    CHECK(grown.overlap(wall) == Approx(1.0));
}

TEST_CASE("a floor reaches along the axes of its largest extent") {
    PlaneFit floor = piece(0.0, 0.0, 6.0, 1.0);
    floor.across_W = floor.normal_W;
    floor.normal_W = Vector3d::UnitZ();
    PlaneFit beyond = floor;
    beyond.centroid_W += 4.0 * floor.along_W;
    beyond.extent_along_m = 1.0 / std::sqrt(12.0);
    CHECK(reach_of(floor).distance(reach_of(beyond)) == Approx(0.5));
}

TEST_CASE("what has never been seen is nowhere") {
    const PlaneReach nothing;
    const PlaneReach wall = reach_of(piece(0.0, 0.0, 4.0, 2.0));
    CHECK(std::isinf(wall.distance(nothing)));
    CHECK(std::isinf(nothing.distance(wall)));
    CHECK(wall.overlap(nothing) == 0.0);
    PlaneReach first;
    first.extend(nothing);
    CHECK(first.empty());
    first.extend(wall);
    CHECK(first.overlap(wall) == Approx(1.0));
}

}  // namespace
}  // namespace facet::plane_reach_test
