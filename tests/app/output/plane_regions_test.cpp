// SPDX-License-Identifier: BSD-2-Clause
// Surfaces of planes as polygons: walls with openings, tables, and what random faces cover.
#include "app/output/plane_regions.h"

#include <catch2/catch.hpp>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>

#include "app/output/plane_log.h"
#include "app/support/ply_reader.h"
#include "tests/support/temp_dir.h"

namespace facet::plane_regions_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kStep_m = 0.25;  // between the corners of faces

/// Faces of a rectangle in several layers, each corner of each face off by millimetres, but for those in `is_open`.
template <class IsOpen>
std::vector<PlaneTriangle> faces_of(const Vector2d& low, const Vector2d& size, IsOpen is_open) {
    std::mt19937 generator(3);
    std::uniform_real_distribution<double> off(-0.004, 0.004);
    std::vector<PlaneTriangle> faces;
    for (int layer = 0; layer < 3; ++layer) {
        for (double x = low.x(); x < low.x() + size.x() - 1e-9; x += kStep_m) {
            for (double y = low.y(); y < low.y() + size.y() - 1e-9; y += kStep_m) {
                if (is_open(x, y)) {
                    continue;
                }
                const auto corner = [&](double dx, double dy) {
                    return Vector2d(x + dx + off(generator), y + dy + off(generator));
                };
                faces.push_back({corner(0, 0), corner(kStep_m, 0), corner(kStep_m, kStep_m)});
                faces.push_back({corner(0, 0), corner(0, kStep_m), corner(kStep_m, kStep_m)});  // clockwise
            }
        }
    }
    return faces;
}

std::vector<PlaneTriangle> wall_with_door() {
    return faces_of({-1.0, 0.5}, {4.0, 2.5}, [](double x, double y) { return x >= 0.5 && x < 1.5 && y < 2.5; });
}

bool is_within(const PlaneRing& ring, const Vector2d& p) {
    bool is_inside = false;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const Vector2d& a = ring[i];
        const Vector2d& b = ring[(i + 1) % ring.size()];
        if ((a.y() > p.y()) != (b.y() > p.y()) && p.x() < a.x() + (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y())) {
            is_inside = !is_inside;
        }
    }
    return is_inside;
}

bool is_within(const PlaneRegion& region, const Vector2d& p) {
    return is_within(region.boundary, p) &&
           std::ranges::none_of(region.holes, [&](const PlaneRing& hole) { return is_within(hole, p); });
}

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

bool do_cross(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d) {
    return cross(b - a, c - a) * cross(b - a, d - a) < -1e-15 && cross(d - c, a - c) * cross(d - c, b - c) < -1e-15;
}

int crossings(const PlaneRegion& region) {
    std::vector<std::pair<Vector2d, Vector2d>> sides;
    const auto take = [&](const PlaneRing& ring) {
        for (std::size_t i = 0; i < ring.size(); ++i) {
            sides.emplace_back(ring[i], ring[(i + 1) % ring.size()]);
        }
    };
    take(region.boundary);
    std::ranges::for_each(region.holes, take);
    int count = 0;
    for (std::size_t i = 0; i < sides.size(); ++i) {
        for (std::size_t j = i + 1; j < sides.size(); ++j) {
            count += do_cross(sides[i].first, sides[i].second, sides[j].first, sides[j].second) ? 1 : 0;
        }
    }
    return count;
}

double area_of(const std::vector<PlaneTriangle>& triangles) {
    double area = 0.0;
    for (const PlaneTriangle& t : triangles) {
        area += signed_area({t[0], t[1], t[2]});
    }
    return area;
}

TEST_CASE("a wall with a door is one region with a notch where the door is") {
    const std::vector<PlaneRegion> regions = find_plane_regions(wall_with_door());
    REQUIRE(regions.size() == 1);
    const PlaneRegion& wall = regions[0];
    CHECK(wall.holes.empty());
    CHECK(wall.area_m2 == Approx(8.0).epsilon(0.02));
    CHECK(signed_area(wall.boundary) == Approx(wall.area_m2));
    CHECK(wall.boundary.size() < 20);
    for (const Vector2d& corner : {Vector2d(-1, 0.5), Vector2d(0.5, 0.5), Vector2d(0.5, 2.5), Vector2d(1.5, 2.5),
                                   Vector2d(1.5, 0.5), Vector2d(3, 0.5), Vector2d(3, 3), Vector2d(-1, 3)}) {
        INFO(corner.transpose());
        CHECK(std::ranges::any_of(wall.boundary, [&](const Vector2d& p) { return (p - corner).norm() < 0.025; }));
    }
    CHECK_FALSE(is_within(wall, {1.0, 0.6}));
    CHECK_FALSE(is_within(wall, {1.0, 2.4}));
    CHECK(is_within(wall, {1.0, 2.6}));
}

TEST_CASE("a wall with a window is one region with a hole; a missing face's width in it is not") {
    auto faces = faces_of({0, 0}, {4.0, 2.5}, [](double x, double y) {
        return (x >= 1.0 && x < 2.5 && y >= 1.0 && y < 2.0) || (x == 3.0 && y == 0.5);
    });
    const std::array<Vector2d, 4> pane{Vector2d(3.0, 0.5), Vector2d(3.25, 0.5), Vector2d(3.25, 0.7),
                                       Vector2d(3.0, 0.7)};
    faces.push_back({pane[0], pane[1], pane[2]});
    faces.push_back({pane[0], pane[2], pane[3]});  // leaves 5 cm of the face open: narrower than what is closed
    const std::vector<PlaneRegion> regions = find_plane_regions(faces);
    REQUIRE(regions.size() == 1);
    REQUIRE(regions[0].holes.size() == 1);
    CHECK(-signed_area(regions[0].holes[0]) == Approx(1.5).epsilon(0.03));
    CHECK(regions[0].area_m2 == Approx(8.5).epsilon(0.02));
    CHECK_FALSE(is_within(regions[0], {1.75, 1.5}));
}

TEST_CASE("table tops at one height are a region each, the largest first, and specks are none") {
    const auto all = [](double, double) { return false; };
    std::vector<PlaneTriangle> faces = faces_of({0, 0}, {0.75, 0.5}, all);
    for (const PlaneTriangle& t : faces_of({1.0, 0}, {1.5, 0.75}, all)) {
        faces.push_back(t);
    }
    faces.push_back({Vector2d(5, 5), Vector2d(5.1, 5), Vector2d(5, 5.1)});
    const std::vector<PlaneRegion> regions = find_plane_regions(faces);
    REQUIRE(regions.size() == 2);
    CHECK(regions[0].area_m2 == Approx(1.125).epsilon(0.03));
    CHECK(regions[1].area_m2 == Approx(0.375).epsilon(0.04));
}

TEST_CASE("whatever the faces: lines do not cross, and the regions cover what the faces do") {
    std::mt19937 generator(11);
    std::uniform_real_distribution<double> place(0.0, 3.0);
    std::uniform_real_distribution<double> side(-0.5, 0.5);
    PlaneRegionOptions options;
    options.gap_m = 0.0;
    options.min_area_m2 = 1e-4;
    for (int round = 0; round < 12; ++round) {
        std::vector<PlaneTriangle> faces;
        for (int i = 0; i < 10 + 4 * round; ++i) {
            const Vector2d at(place(generator), place(generator));
            faces.push_back(
                {at, at + Vector2d(side(generator), side(generator)), at + Vector2d(side(generator), side(generator))});
        }
        const std::vector<PlaneRegion> regions = find_plane_regions(faces, options);
        int wrong = 0;
        constexpr int kSamples = 4000;
        for (int i = 0; i < kSamples; ++i) {
            const Vector2d p(place(generator), place(generator));
            const bool is_covered = std::ranges::any_of(faces, [&](const PlaneTriangle& t) {
                return is_within({t[0], t[1], t[2]}, p);
            });
            const auto holders = std::ranges::count_if(regions, [&](const PlaneRegion& r) { return is_within(r, p); });
            wrong += holders != (is_covered ? 1 : 0) ? 1 : 0;
        }
        CHECK(wrong < 0.03 * kSamples);  // along the lines
        for (const PlaneRegion& region : regions) {
            CHECK(crossings(region) == 0);
            CHECK(area_of(triangulate(region)) == Approx(region.area_m2).margin(2e-3));
        }
    }
}

TEST_CASE("faces that are not finite or out of this world are left out, and a large plane gets larger cells") {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    CHECK(find_plane_regions({}).empty());
    std::vector<PlaneTriangle> faces{{Vector2d(nan, 0), Vector2d(1, 0), Vector2d(0, 1)},
                                     {Vector2d(0, 0), Vector2d(1e9, 0), Vector2d(0, 1)},
                                     {Vector2d(0, 0), Vector2d(1, 1), Vector2d(2, 2)}};  // without area
    CHECK(find_plane_regions(faces).empty());
    faces.push_back({Vector2d(-2000, 0), Vector2d(2000, 0), Vector2d(0, 1500)});
    const std::vector<PlaneRegion> regions = find_plane_regions(faces);
    REQUIRE(regions.size() == 1);
    CHECK(regions[0].area_m2 == Approx(3e6).epsilon(0.01));
}

PlaneFit slanted_wall() {
    PlaneFit fit;
    fit.normal_W = Vector3d(0.6, -0.8, 0.02).normalized();
    fit.centroid_W = {3.0, 1.0, -2.0};
    fit.distance_m = fit.normal_W.dot(fit.centroid_W) + 0.01;
    fit.along_W = Vector3d::UnitZ().cross(fit.normal_W).cross(fit.normal_W).normalized();  // upright
    fit.across_W = fit.normal_W.cross(fit.along_W);
    fit.sigma_m = 0.002;
    fit.sigma_along_rad = 0.003;
    fit.sigma_across_rad = 0.007;
    return fit;
}

TEST_CASE("a wall's axes are level and upward, a floor's the landmarks', and points keep their place") {
    const PlaneFit fit = slanted_wall();
    const PlaneAxes wall(fit, PlaneKind::kVertical);
    CHECK(wall.R_W_A.col(0).z() == Approx(0.0).margin(1e-12));
    CHECK(wall.R_W_A.col(1).z() > 0.99);
    CHECK((wall.R_W_A.transpose() * wall.R_W_A - Eigen::Matrix3d::Identity()).norm() < 1e-12);
    CHECK(wall.R_W_A.determinant() == Approx(1.0));
    CHECK(std::abs(fit.residual(wall.origin_W)) < 1e-12);
    CHECK(wall.sigma_turn.x() == Approx(fit.sigma_across_rad));
    CHECK(wall.sigma_turn.y() == Approx(fit.sigma_along_rad));
    const Vector2d at(0.7, -0.4);
    CHECK((wall.to_plane(wall.to_world(at)) - at).norm() < 1e-12);
    CHECK(std::abs(fit.residual(wall.to_world(at))) < 1e-12);
    const PlaneAxes ramp(fit, PlaneKind::kSlanted);
    CHECK((ramp.R_W_A - wall.R_W_A).norm() < 1e-12);
    const PlaneAxes floor(fit, PlaneKind::kHorizontal);
    CHECK((floor.R_W_A.col(0) - fit.along_W).norm() < 1e-9);
}

TEST_CASE("planes.json and planes.ply hold the regions of the plane that faces lie on") {
    TrackedPlane plane;
    plane.id = PlaneId{4};
    plane.kind = PlaneKind::kVertical;
    plane.is_reported = true;
    plane.fit = slanted_wall();
    const PlaneAxes axes(plane.fit, plane.kind);
    std::vector<DepartedFace> faces;
    for (const PlaneTriangle& t : wall_with_door()) {
        DepartedFace& face = faces.emplace_back();
        face.plane = plane.id;
        for (std::size_t k = 0; k < 3; ++k) {
            face.p_W[k] = (axes.to_world(t[k]) + 0.005 * plane.fit.normal_W).cast<float>();
        }
    }
    faces.emplace_back().p_W = {Eigen::Vector3f(0, 0, 0), Eigen::Vector3f(9, 0, 0),
                                Eigen::Vector3f(0, 9, 0)};  // no plane
    const test::TempDir folder;
    PlaneLog log(folder.path());
    log.write(Timestamp{1}, {&plane, 1}, {&plane.fit, 1});
    log.close();
    log.write_planes(folder.path(), faces);

    const nlohmann::json planes = nlohmann::json::parse(test::read_file(folder.file("planes.json")));
    REQUIRE(planes.size() == 1);
    CHECK(planes[0]["sigma"] == plane.fit.sigma_m);
    REQUIRE(planes[0]["regions"].size() == 1);
    const nlohmann::json& region = planes[0]["regions"][0];
    CHECK(region["area"].get<double>() == Approx(8.0).epsilon(0.02));
    CHECK(region["holes"].empty());
    const auto vector = [](const nlohmann::json& v) { return Vector3d(v.at(0), v.at(1), v.at(2)); };
    PlaneRing boundary;
    for (const nlohmann::json& p : region["boundary"]) {
        boundary.emplace_back(p.at(0), p.at(1));
        const Vector3d p_W = vector(planes[0]["origin"]) + boundary.back().x() * vector(planes[0]["axes"][0]) +
                             boundary.back().y() * vector(planes[0]["axes"][1]);
        CHECK(std::abs(plane.fit.residual(p_W)) < 1e-9);
    }
    CHECK(signed_area(boundary) == Approx(region["area"].get<double>()).epsilon(1e-6));

    PlyTriangles surface;
    std::string error;
    REQUIRE(ok(read_ply(folder.file("planes.ply"), surface, error)));
    double area = 0.0;
    for (const Eigen::Vector3i& t : surface.triangles) {
        const auto p = [&](int k) { return surface.vertices[static_cast<std::size_t>(t[k])]; };
        area += 0.5 * (p(1) - p(0)).cross(p(2) - p(0)).dot(plane.fit.normal_W);  // seen from the normal's side
        CHECK(std::abs(plane.fit.residual(p(0))) < 1e-5);
    }
    CHECK(area == Approx(region["area"].get<double>()).epsilon(1e-3));
}

TEST_CASE("planes.json has a plane as it was when known best, not as it was when it left the view") {
    const test::TempDir folder;
    TrackedPlane plane;
    plane.id = {4};
    plane.is_reported = true;
    const auto tell = [&](PlaneLog& log, int keyframe, double distance, double sigma_across, int lost) {
        plane.fit.distance_m = distance;
        plane.fit.sigma_m = 0.002;
        plane.fit.sigma_along_rad = 0.01;
        plane.fit.sigma_across_rad = sigma_across;
        plane.lost = lost;
        log.write(Timestamp{keyframe}, {&plane, 1}, {&plane.fit, 1});
    };
    PlaneLog log(folder.path());
    tell(log, 1, 1.0, 0.03, 0);
    tell(log, 2, 2.0, 0.01, 0);
    tell(log, 3, 3.0, 0.02, 0);
    tell(log, 4, 4.0, 0.001, 1);  // not seen any more: nothing has been learnt
    log.close();
    log.write_planes(folder.path(), {});
    const nlohmann::json planes = nlohmann::json::parse(test::read_file(folder.file("planes.json")));
    REQUIRE(planes.size() == 1);
    CHECK(planes[0]["distance"] == 2.0);
    CHECK(planes[0]["first_stamp_ns"] == 1);
    CHECK(planes[0]["last_stamp_ns"] == 4);
}

TEST_CASE("planes.json reports uncertainty in the world, not that of the landmarks alone") {
    const test::TempDir folder;
    TrackedPlane plane;
    plane.id = {4};
    plane.is_reported = true;
    PlaneLog log(folder.path());
    for (const double drift : {0.01, 0.05}) {
        plane.fit.distance_m = drift;
        plane.fit.sigma_m = plane.fit.sigma_along_rad = plane.fit.sigma_across_rad = drift < 0.02 ? 0.0015 : 0.001;
        PlaneFit claim = plane.fit;
        claim.sigma_m = drift;
        claim.sigma_along_rad = claim.sigma_across_rad = 0.002;
        log.write(Timestamp{1}, {&plane, 1}, {&claim, 1});
    }
    log.close();
    log.write_planes(folder.path(), {});
    const nlohmann::json planes = nlohmann::json::parse(test::read_file(folder.file("planes.json")));
    REQUIRE(planes.size() == 1);
    CHECK(planes[0]["distance"] == 0.01);
    CHECK(planes[0]["sigma"] == 0.01);
}

TEST_CASE("planes that turn out to be one are one in planes.json, with the surfaces of both") {
    const test::TempDir folder;
    TrackedPlane plane;
    plane.is_reported = true;
    PlaneLog log(folder.path());
    const auto tell = [&](std::int64_t keyframe, std::uint32_t id, double sigma,
                          std::initializer_list<PlaneMerge> merges) {
        plane.id = {id};
        plane.fit.distance_m = 0.01 * id;
        plane.fit.sigma_m = plane.fit.sigma_along_rad = plane.fit.sigma_across_rad = sigma;
        log.write(Timestamp{keyframe}, {&plane, 1}, {&plane.fit, 1}, {merges.begin(), merges.size()});
    };
    tell(1, 2, 0.003, {});
    tell(2, 5, 0.001, {});
    tell(3, 7, 0.002, {{{7}, {5}}});  // of one that was told before, and is told once more under its old id
    tell(4, 9, 0.004, {{{7}, {5}}, {{5}, {2}}});
    log.close();
    CHECK(log.names().now({7}) == PlaneId{2});
    CHECK(log.names().now({9}) == PlaneId{9});
    CHECK_FALSE(log.names().now({}).valid());
    std::vector<DepartedFace> faces;
    for (const std::uint32_t id : {2U, 5U, 7U}) {
        const auto x = static_cast<float>(id);
        DepartedFace& face = faces.emplace_back();
        face.plane = {id};
        face.p_W = {Eigen::Vector3f(x, 0, 0), Eigen::Vector3f(x + 1, 0, 0), Eigen::Vector3f(x, 1, 0)};
    }
    log.write_planes(folder.path(), faces);
    const nlohmann::json planes = nlohmann::json::parse(test::read_file(folder.file("planes.json")));
    REQUIRE(planes.size() == 2);
    CHECK(planes[0]["id"] == 2);
    CHECK(planes[0]["distance"] == 0.05);  // as known best
    CHECK(planes[0]["first_stamp_ns"] == 1);
    CHECK(planes[0]["last_stamp_ns"] == 3);
    CHECK(planes[0]["regions"].size() == 3);
    CHECK(planes[1]["id"] == 9);
}

TEST_CASE("a young plane that its landmarks refute is taken back; an old one, or one still reported, is not") {
    const auto listed = [](int found, bool comes_back) {
        const test::TempDir folder;
        TrackedPlane plane;
        plane.id = {4};
        plane.is_reported = true;
        PlaneLog log(folder.path());
        for (const int doubts : {0, 1}) {
            plane.found = found;
            plane.doubts = plane.lost = doubts;
            log.write(Timestamp{doubts + 1}, {&plane, 1}, {&plane.fit, 1});
        }
        plane.doubts = plane.lost = 0;
        plane.is_reported = comes_back;  // doubted again, it is no longer told
        log.write(Timestamp{3}, {&plane, 1}, {&plane.fit, 1});
        log.close();
        log.write_planes(folder.path(), {});
        return nlohmann::json::parse(test::read_file(folder.file("planes.json"))).size();
    };
    CHECK(listed(2, false) == 0);
    CHECK(listed(8, false) == 0);
    CHECK(listed(9, false) == 1);
    CHECK(listed(2, true) == 1);
}

}  // namespace
}  // namespace facet::plane_regions_test
