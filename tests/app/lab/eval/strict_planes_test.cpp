// SPDX-License-Identifier: BSD-2-Clause
// Planes judged strictly, with the regions that a run tells of them.
#include "app/lab/eval/strict_planes.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "app/support/input_error.h"
#include "tests/support/temp_dir.h"

namespace facet::strict_planes_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// A wall at x = 3 m on both sides of a door, 2 m each and 1.4 m apart, as two planes of the scene.
SceneTruth wall_with_door() {
    SceneTruth truth;
    for (const double y : {-2.7, 0.7}) {
        const auto n = static_cast<int>(truth.surface.vertices.size());
        truth.surface.vertices.insert(truth.surface.vertices.end(),
                                      {{3.0, y, 0.0}, {3.0, y, 2.0}, {3.0, y + 2.0, 2.0}, {3.0, y + 2.0, 0.0}});
        truth.surface.triangles.push_back({n, n + 1, n + 2});
        truth.surface.triangles.push_back({n, n + 2, n + 3});
        EvalPlane plane{y < 0.0 ? "left" : "right", {-1.0, 0.0, 0.0}, -3.0};
        plane.box = {Vector3d(3.0, y, 0.0), Vector3d(3.0, y + 2.0, 2.0)};
        truth.planes.push_back(plane);
    }
    return truth;
}

/// Its landmarks are at the jambs, so that their centroid is in the door.
PlaneRow row(std::uint32_t id, double x = 3.0) {
    PlaneRow r;
    r.id = id;
    r.normal = {-1.0, 0.0, 0.0};
    r.distance = -x;
    r.centroid = {x, 0.0, 1.0};
    r.area_m2 = 1.5;
    return r;
}

/// Rectangles of the plane x = 3 m.
PlaneSurface rectangles(std::initializer_list<Eigen::AlignedBox2d> boxes) {
    PlaneOutline outline{{3.0, 0.0, 0.0}, {Vector3d::UnitY(), Vector3d::UnitZ()}, {}};
    for (const Eigen::AlignedBox2d& box : boxes) {
        outline.lines.push_back({box.corner(box.BottomLeft), box.corner(box.BottomRight), box.corner(box.TopRight),
                                 box.corner(box.TopLeft)});
    }
    return {{-1.0, 0.0, 0.0}, fill(outline)};
}

const Eigen::AlignedBox2d kLeft(Vector2d(-1.4, 0.2), Vector2d(-0.7, 1.8));
const Eigen::AlignedBox2d kRight(Vector2d(0.7, 0.2), Vector2d(1.2, 1.8));
const Eigen::AlignedBox2d kDoor(Vector2d(-0.7, 0.2), Vector2d(0.7, 1.8));

StrictPlanes judge(const std::vector<PlaneRow>& rows, const std::optional<PlaneSurfaces>& surfaces) {
    const SceneTruth truth = wall_with_door();
    return judge_strictly(rows, surfaces, truth, TriangleTree(truth.surface), Se3{}, {4.0, 4.0});
}

TEST_CASE("a wall on both sides of a door is where its regions are, not about the centroid of its landmarks") {
    const StrictPlanes both = judge({row(1)}, PlaneSurfaces{{1, rectangles({kLeft, kRight})}});
    CHECK(both.right == 1);
    CHECK(both.wanted == 2);
    CHECK(both.wanted_found == 1);  // the left half, which has more of it
    CHECK(both.area_recall() == 0.5);
    CHECK(judge({row(1)}, std::nullopt).right == 0);                                      // a disc in the door
    const StrictPlanes other = judge({row(1)}, PlaneSurfaces{{2, rectangles({kLeft})}});  // taken back
    CHECK(other.found == 0);
    CHECK(other.taken_back == 1);
    CHECK(judge({row(1)}, PlaneSurfaces{}).taken_back == 1);
}

TEST_CASE("a plane over an opening, or off its surface, is wrong however right its regions' place is") {
    CHECK(judge({row(1)}, PlaneSurfaces{{1, rectangles({kLeft, kDoor})}}).right == 0);  // a third of it is wall
    CHECK(judge({row(1)}, PlaneSurfaces{{1, rectangles({kLeft, kRight, {Vector2d(-0.7, 0.2), Vector2d(0.0, 1.8)}})}})
              .right == 1);
    CHECK(judge({row(1, 3.04)}, PlaneSurfaces{{1, rectangles({kLeft, kRight})}}).right == 0);
    CHECK(judge({row(1)}, PlaneSurfaces{{1, PlaneSurface{{-1.0, 0.0, 0.0}, {}}}}).right == 0);
    CHECK(judge({row(1), row(2)}, PlaneSurfaces{{1, rectangles({kLeft})}, {2, rectangles({kRight})}}).right == 2);
    CHECK(judge({row(1), row(2)}, PlaneSurfaces{{1, rectangles({kLeft})}, {2, rectangles({kLeft})}}).right == 1);
}

/// What planes.json claims: the wall's place to 1 cm, its turns to 0.01 rad.
PlaneSurface with_claim(PlaneSurface surface, double x) {
    surface.claim = PlaneClaim{{x, 0.0, 1.0}, {Vector3d::UnitZ(), Vector3d::UnitY()}, 0.01, {0.01, 0.01}};
    return surface;
}

TEST_CASE("each plane has a verdict why it is wrong, and by how many of its own sigmas") {
    const PlaneSurface left = with_claim(rectangles({kLeft}), 3.01);
    const StrictPlanes both = judge({row(1), row(2)}, PlaneSurfaces{{1, left}, {2, left}});
    REQUIRE(both.verdicts.size() == 2);
    CHECK(both.verdicts[0].cause == StrictCause::kRight);
    CHECK(both.verdicts[1].cause == StrictCause::kDuplicate);
    REQUIRE(both.verdicts[0].error.has_value());
    CHECK(both.verdicts[0].error->offset_m == Approx(0.01));
    CHECK(both.verdicts[0].error->sigmas.isApprox(Vector3d(-1.0, 0.0, 0.0), 1e-6));
    CHECK(both.confident == 0);

    const StrictPlanes off = judge({row(1, 3.04)}, PlaneSurfaces{{1, with_claim(rectangles({kLeft}), 3.04)}});
    CHECK(off.verdicts.at(0).cause == StrictCause::kOff);
    CHECK(off.verdicts[0].truth == 0);
    CHECK(off.verdicts[0].error.value().offset_m == Approx(0.04));
    CHECK(off.confident == 1);  // 4 sigmas

    const Eigen::AlignedBox2d within_door(Vector2d(-0.4, 0.2), Vector2d(0.4, 1.8));
    const StrictPlanes open = judge({row(1)}, PlaneSurfaces{{1, with_claim(rectangles({within_door}), 3.0)}});
    CHECK(open.verdicts.at(0).cause == StrictCause::kNoSurface);
    CHECK(open.verdicts[0].share == 0.0);
    CHECK_FALSE(open.verdicts[0].error.has_value());
    CHECK(open.confident == 1);
}

TEST_CASE("a rotated plane's error is reported by axis") {
    const double turn = 0.02;
    const PlaneClaim claim{
        {3.0, 0.0, 1.0}, {Vector3d(std::sin(turn), 0.0, std::cos(turn)), Vector3d::UnitY()}, 0.01, {0.01, 0.01}};
    const PlaneError error = error_of(claim, wall_with_door().planes[0], Se3{});
    CHECK(error.offset_m == Approx(0.0).margin(1e-12));
    CHECK(error.angle_deg == Approx(turn * 180.0 / 3.14159265).epsilon(1e-6));
    CHECK(error.sigmas[1] == Approx(-2.0).epsilon(1e-3));
    CHECK(error.sigmas[2] == Approx(0.0).margin(1e-9));
}

TEST_CASE("regions are filled up to their boundary, without their holes") {
    const test::TempDir folder;
    folder.write("planes.json", R"([{"id": 3, "normal": [0, 0, 1], "distance": 1, "origin": [10, 0, 1],
        "axes": [[1, 0, 0], [0, 1, 0]], "regions": [
            {"area": 3.0, "boundary": [[0, 0], [2, 0], [2, 2], [0, 2]], "holes": [[[0.5, 0.5], [0.5, 1.5], [1.5, 1.5], [1.5, 0.5]]]},
            {"area": 0.5, "boundary": [[3, 0], [4, 0], [4, 1]], "holes": []}]},
        {"id": 4, "normal": [0, 0, 1], "distance": 1}])");
    const PlaneSurfaces surfaces = load_surfaces(folder.file("planes.json")).value();
    REQUIRE(surfaces.size() == 2);
    CHECK_FALSE(surfaces.at(4).has_regions);
    const PlaneSurface& surface = surfaces.at(3);
    CHECK(surface.normal == Vector3d::UnitZ());
    CHECK(static_cast<double>(surface.squares.size()) * kSurfaceSquare_m * kSurfaceSquare_m ==
          Approx(3.5).epsilon(0.02));
    for (const Vector3d& square : surface.squares) {
        const Vector2d at(square.x() - 10.0, square.y());
        const bool is_in_ring = at.x() < 2.0 && at.y() < 2.0 && (at.array() - 1.0).abs().maxCoeff() > 0.5;
        const bool is_in_triangle = at.x() > 3.0 && at.x() < 4.0 && at.y() < at.x() - 3.0 + 1e-9;
        CHECK((is_in_ring || is_in_triangle));
        CHECK(square.z() == 1.0);
    }
}

TEST_CASE("regions that cannot be used are refused; a run without planes.json has none") {
    const test::TempDir folder;
    CHECK_FALSE(load_surfaces(folder.file("planes.json")).has_value());
    const auto load_with = [&](const std::string& axes, const std::string& regions) {
        folder.write("planes.json", R"([{"id": 3, "normal": [0, 0, 1], "distance": 1, "origin": [0, 0, 1], "axes": )" +
                                        axes + R"(, "regions": )" + regions + "}]");
        return load_surfaces(folder.file("planes.json")).value();
    };
    const std::string axes = "[[1, 0, 0], [0, 1, 0]]";
    CHECK_FALSE(load_with(axes, "[]").at(3).has_regions);
    CHECK(load_with(axes, R"([{"boundary": [], "holes": []}])").at(3).squares.empty());
    CHECK_THROWS_AS(load_with("[[1, 0, 0]]", "[]"), InputError);
    CHECK_THROWS_AS(load_with(axes, "7"), InputError);
    CHECK_THROWS_AS(load_with(axes, "[7]"), InputError);
    CHECK_THROWS_AS(load_with(axes, R"([{"boundary": [[0, 0], [1, 0]]}])"), InputError);
    CHECK_THROWS_AS(load_with(axes, R"([{"boundary": [[0, 0, 0]], "holes": []}])"), InputError);
    CHECK_THROWS_AS(load_with(axes, R"([{"boundary": [[0, 1e300]], "holes": []}])"), InputError);
    CHECK_THROWS_AS(load_with(axes, R"([{"boundary": [[0, 0], [1e6, 0], [0, 1]], "holes": []}])"), InputError);
    CHECK_THROWS_AS(load_surfaces(folder.path()), InputError);
}

}  // namespace
}  // namespace facet::strict_planes_test
