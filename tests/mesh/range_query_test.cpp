// SPDX-License-Identifier: BSD-2-Clause
// Every query against brute force that shares no code with it.
#include "mesh/range_query.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <numbers>
#include <vector>

#include "tests/mesh/mesh_samples.h"
#include "tests/support/allocation_guard.h"

namespace facet::range_query_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double kTolerance = 2e-5;  // m: the mesh is kept as floats

std::vector<std::array<Vector3d, 3>> triangles_of(const HorizonMesh& mesh) {
    std::vector<std::array<Vector3d, 3>> triangles;
    for (int i = 0; i < mesh.face_end(); ++i) {
        if (mesh.is_face(i)) {
            const MeshFace& f = mesh.face(static_cast<FaceIndex>(i));
            triangles.push_back({mesh.corner(f, 0), mesh.corner(f, 1), mesh.corner(f, 2)});
        }
    }
    return triangles;
}

/// Distance along the ray by solving p + t d = a + u (b-a) + v (c-a).
double brute_cast(const std::vector<std::array<Vector3d, 3>>& triangles, const Vector3d& p, const Vector3d& d,
                  double range) {
    double best = range;
    for (const auto& [a, b, c] : triangles) {
        Eigen::Matrix3d m;
        m << b - a, c - a, -d;
        const Vector3d x = m.fullPivLu().solve(p - a);
        if (x.x() >= 0.0 && x.y() >= 0.0 && x.x() + x.y() <= 1.0 && x.z() >= 0.0) {
            best = std::min(best, x.z());
        }
    }
    return best;
}

/// Calls visit for a grid of points of the triangle about `step` apart.
template <class Visit>
void for_points(const std::array<Vector3d, 3>& t, double step, Visit visit) {
    const double longest = std::max({(t[1] - t[0]).norm(), (t[2] - t[1]).norm(), (t[0] - t[2]).norm()});
    const auto n = static_cast<unsigned>(std::clamp(longest / step, 2.0, 1000.0));
    const double share = 1.0 / n;
    for (unsigned i = 0; i <= n; ++i) {
        for (unsigned j = 0; i + j <= n; ++j) {
            visit((t[0] + i * share * (t[1] - t[0]) + j * share * (t[2] - t[0])).eval());
        }
    }
}

struct Scene {
    std::unique_ptr<HorizonMesh> mesh;
    std::unique_ptr<RangeQuery> query = std::make_unique<RangeQuery>();
    std::vector<std::array<Vector3d, 3>> triangles;
    explicit Scene(int faces, unsigned seed, double size = 0.6)
        : mesh(test::random_mesh(faces, seed, size)), triangles(triangles_of(*mesh)) {
        query->update(*mesh);
    }
};

Vector3d random_unit(std::mt19937& random) {
    std::normal_distribution<double> normal;
    const double x = normal(random);
    const double y = normal(random);
    return Vector3d(x, y, normal(random)).normalized();
}

TEST_CASE("a ray finds the first face") {
    const Scene scene(2000, 1);
    std::mt19937 random(1);
    int hits = 0;
    for (int i = 0; i < 300; ++i) {
        const Vector3d p = 5.0 * random_unit(random);
        const Vector3d d = random_unit(random);
        const double truth = brute_cast(scene.triangles, p, d, 12.0);
        const RangeHit hit = scene.query->cast(p, 3.0 * d, 12.0);
        REQUIRE(hit.distance_m == Approx(truth).margin(kTolerance));
        REQUIRE(hit.found() == (truth < 12.0));
        if (hit.found()) {
            ++hits;
            REQUIRE((hit.p_W - p - truth * d).norm() < 1e-4);
        }
    }
    CHECK(hits > 30);
}

TEST_CASE("the nearest point is not farther than any sample, and is a point of its face") {
    const Scene scene(500, 2);
    std::mt19937 random(2);
    for (int i = 0; i < 60; ++i) {
        const Vector3d p = 6.0 * random_unit(random);
        double sampled = 20.0;
        for (const auto& t : scene.triangles) {
            for_points(t, 0.05, [&](const Vector3d& q) { sampled = std::min(sampled, (q - p).norm()); });
        }
        const RangeHit hit = scene.query->nearest(p, 20.0);
        REQUIRE(hit.found());
        REQUIRE(hit.distance_m <= sampled + kTolerance);
        REQUIRE(hit.distance_m >= sampled - 0.05);
        REQUIRE((hit.p_W - p).norm() == Approx(hit.distance_m).margin(kTolerance));
        const MeshFace& f = scene.mesh->face(hit.face);
        Eigen::Matrix3d m;
        m << scene.mesh->corner(f, 0), scene.mesh->corner(f, 1), scene.mesh->corner(f, 2);
        const Vector3d weights = m.fullPivLu().solve(hit.p_W);
        REQUIRE(weights.minCoeff() > -1e-3);
        REQUIRE(weights.sum() == Approx(1.0).margin(1e-3));
    }
}

TEST_CASE("the nearest point in a cone is not farther than any sample in it") {
    const Scene scene(300, 3);
    std::mt19937 random(3);
    int found = 0;
    for (int i = 0; i < 150; ++i) {
        const Vector3d p = 6.0 * random_unit(random);
        const Vector3d axis = random_unit(random);
        const double half = 0.05 + 0.01 * i;
        const auto nearest_within = [&](double angle) {
            double best = 15.0;
            for (const auto& t : scene.triangles) {
                for_points(t, 0.03, [&](const Vector3d& q) {
                    const double distance = (q - p).norm();
                    if (axis.dot(q - p) >= std::cos(angle) * distance) {
                        best = std::min(best, distance);
                    }
                });
            }
            return best;
        };
        const RangeHit hit = scene.query->nearest_in_direction(p, 2.0 * axis, half, 15.0);
        REQUIRE(hit.distance_m <= nearest_within(half) + kTolerance);
        // Every point of the mesh has a sample within 3 cm; seen from a metre or more that is below 0.035 rad.
        if (hit.distance_m > 1.0) {
            REQUIRE(hit.distance_m >= nearest_within(half + 0.035) - 0.035);
        }
        if (hit.found()) {
            ++found;
            REQUIRE(axis.dot(hit.p_W - p) >= std::cos(half) * hit.distance_m - 1e-4);
        }
    }
    CHECK(found > 50);
}

/// Clips a convex polygon by a . x >= c.
std::vector<Vector3d> clip(const std::vector<Vector3d>& polygon, const Vector3d& a, double c) {
    std::vector<Vector3d> kept;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vector3d& p = polygon[i];
        const Vector3d& q = polygon[(i + 1) % polygon.size()];
        const double dp = a.dot(p) - c;
        const double dq = a.dot(q) - c;
        if (dp >= 0.0) {
            kept.push_back(p);
        }
        if ((dp < 0.0) != (dq < 0.0)) {
            kept.push_back(p + dp / (dp - dq) * (q - p));
        }
    }
    return kept;
}

/// Horizontal distance of the polygon's border to the z axis.
double border_distance(const std::vector<Vector3d>& polygon) {
    double best = 1e9;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vector2d a = polygon[i].head<2>();
        const Vector2d side = polygon[(i + 1) % polygon.size()].head<2>() - a;
        const double t = std::clamp(-a.dot(side) / std::max(side.squaredNorm(), 1e-300), 0.0, 1.0);
        best = std::min(best, (a + t * side).norm());
    }
    return best;
}

/// Each sector by clipping every face to the band and the wedge.
std::array<double, kSweepSectors> brute_sweep(const std::vector<std::array<Vector3d, 3>>& triangles,
                                              const SweepRequest& request, double widen_rad) {
    std::array<double, kSweepSectors> range{};
    const double width = 2.0 * std::numbers::pi / kSweepSectors;
    for (int k = 0; k < kSweepSectors; ++k) {
        const double a0 = request.start_rad + k * width - widen_rad;
        const double a1 = request.start_rad + (k + 1) * width + widen_rad;
        double best = request.max_range_m;
        for (const auto& t : triangles) {
            std::vector<Vector3d> polygon{t[0] - request.p_W, t[1] - request.p_W, t[2] - request.p_W};
            polygon = clip(polygon, -Vector3d::UnitZ(), -request.above_m);
            polygon = clip(polygon, Vector3d::UnitZ(), -request.below_m);
            polygon = clip(polygon, Vector3d(-std::sin(a0), std::cos(a0), 0.0), 0.0);
            polygon = clip(polygon, Vector3d(std::sin(a1), -std::cos(a1), 0.0), 0.0);
            best = std::min(best, border_distance(polygon));
        }
        range[static_cast<std::size_t>(k)] = best;
    }
    return range;
}

TEST_CASE("a sweep of 72 sectors equals clipping every face to every sector") {
    int obstacles = 0;
    for (unsigned seed = 0; seed < 12; ++seed) {
        const Scene scene(400, seed, seed % 3 == 0 ? 2.5 : 0.5);
        SweepRequest request;
        request.p_W = {0.3 * seed - 1.0, 0.5, 0.1 * seed};
        request.start_rad = 1.7 * seed - 4.0;
        request.below_m = 0.3 + 0.1 * seed;
        request.above_m = 0.2;
        request.max_range_m = 8.0;
        std::array<double, kSweepSectors> range{};
        scene.query->sweep(request, range);
        // No face ends exactly at the edge of a sector, but rounding to float moves faces: compare with wedges that are
        // a little narrower and wider.
        const auto narrow = brute_sweep(scene.triangles, request, -1e-5);
        const auto wide = brute_sweep(scene.triangles, request, 1e-5);
        for (std::size_t k = 0; k < range.size(); ++k) {
            INFO("seed " << seed << " sector " << k);
            REQUIRE(range[k] <= narrow[k] + 1e-4);
            REQUIRE(range[k] >= wide[k] - 1e-4);
            obstacles += range[k] < request.max_range_m ? 1 : 0;
        }
    }
    CHECK(obstacles > 200);
}

TEST_CASE("a wall, a floor below the vehicle, and an empty mesh") {
    HorizonMesh mesh;
    RangeQuery query;
    std::array<double, kSweepSectors> range{};
    query.update(mesh);
    query.sweep({}, range);
    CHECK(range[0] == 10.0);
    CHECK_FALSE(query.cast(Vector3d::Zero(), Vector3d::UnitX(), 5.0).found());
    CHECK_FALSE(query.nearest(Vector3d::Zero(), 5.0).found());
    const VertexSlot a = test::add_vertex(mesh, 0, {3.0, -9.0, -5.0});
    const VertexSlot b = test::add_vertex(mesh, 1, {3.0, 9.0, -5.0});
    const VertexSlot c = test::add_vertex(mesh, 2, {3.0, 0.0, 9.0});
    REQUIRE(mesh.add_face({a, b, c}).ok());
    query.update(mesh, 0);
    CHECK(query.nearest(Vector3d::Zero(), 5.0).distance_m == Approx(3.0));
    CHECK(query.cast(Vector3d::Zero(), Vector3d(1.0, 1.0, 0.0), 5.0).distance_m == Approx(3.0 * std::sqrt(2.0)));
    query.sweep({}, range);
    CHECK(range[0] == Approx(3.0));  // towards +x
    CHECK(range[36] == 10.0);        // towards -x
    CHECK(range[8] == Approx(3.0 / std::cos(40.0 * std::numbers::pi / 180.0)));
    const VertexSlot d = test::add_vertex(mesh, 3, {-2.0, -2.0, -0.2});
    const VertexSlot e = test::add_vertex(mesh, 4, {2.0, -2.0, -0.2});
    const VertexSlot f = test::add_vertex(mesh, 5, {0.0, 3.0, -0.2});
    REQUIRE(mesh.add_face({d, e, f}).ok());
    query.update(mesh, 0);
    query.sweep({}, range);
    CHECK(*std::max_element(range.begin(), range.end()) == 0.0);  // it is above a face within its band
}

TEST_CASE("queries of a full mesh need no heap") {
    const Scene scene(kMaxMeshFaces, 9);
    REQUIRE(scene.query->faces() == kMaxMeshFaces);
    std::array<double, kSweepSectors> range{};
    const test::AllocationGuard guard;
    for (int i = 0; i < 5; ++i) {
        SweepRequest request;
        request.p_W = {0.6 * i, 0.2, 0.0};
        scene.query->sweep(request, range);
        static_cast<void>(scene.query->nearest(request.p_W, 10.0));
        static_cast<void>(scene.query->cast(request.p_W, Vector3d::UnitX(), 10.0));
        static_cast<void>(scene.query->nearest_in_direction(request.p_W, Vector3d::UnitX(), 0.2, 10.0));
    }
    const std::uint64_t allocations = guard.allocations();
    CHECK(allocations == 0);
}

}  // namespace
}  // namespace facet::range_query_test
