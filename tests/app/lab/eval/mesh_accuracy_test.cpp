// SPDX-License-Identifier: BSD-2-Clause
// Mesh evaluation on surfaces whose distances are known.
#include "app/lab/eval/mesh_accuracy.h"

#include <array>
#include <catch2/catch.hpp>
#include <random>

#include "app/lab/eval/scene_truth.h"
#include "app/support/ply_writer.h"
#include "tests/support/ideal_camera.h"
#include "tests/support/input_error_text.h"
#include "tests/support/temp_dir.h"

namespace facet::mesh_accuracy_test {
namespace {

using Eigen::Vector3d;

/// A rectangle in the plane x = depth, divided into cells of `step`; cells for which skip(y, z) holds are left out.
template <class Skip>
TriangleSoup wall(double depth, double half, double step, Skip skip) {
    TriangleSoup soup;
    for (double y = -half; y < half - 1e-9; y += step) {
        for (double z = -half; z < half - 1e-9; z += step) {
            if (skip(y, z)) {
                continue;
            }
            const auto n = static_cast<int>(soup.vertices.size());
            soup.vertices.insert(
                soup.vertices.end(),
                {{depth, y, z}, {depth, y + step, z}, {depth, y + step, z + step}, {depth, y, z + step}});
            soup.triangles.push_back({n, n + 1, n + 2});
            soup.triangles.push_back({n, n + 2, n + 3});
        }
    }
    return soup;
}

TriangleSoup whole_wall(double depth, double half) {
    return wall(depth, half, 0.25, [](double, double) { return false; });
}

/// A wall at x = 3 m, four by four metres, seen whole from the origin.
SceneTruth scene() {
    SceneTruth truth;
    truth.surface = whole_wall(3.0, 2.0);
    truth.planes = {{"wall", Vector3d(-1.0, 0.0, 0.0), -3.0}};
    truth.camera = test::ideal_camera(800, 800, 450.0);
    truth.T_W_C0 = {test::looking_along_x()};
    return truth;
}

TEST_CASE("a mesh in millimetres is refused before its surface is sampled") {
    const test::TempDir dir;
    const std::array<Eigen::Vector3f, 3> vertices{Eigen::Vector3f::Zero(), Eigen::Vector3f(5000.0F, 0.0F, 0.0F),
                                                  Eigen::Vector3f(0.0F, 5000.0F, 0.0F)};
    const std::array<Eigen::Vector3i, 1> triangle{Eigen::Vector3i(0, 1, 2)};
    REQUIRE(ok(write_ply(dir.file("mm.ply"), "", vertices, triangle)));
    CHECK(test::input_error_text([&] { load_mesh(dir.file("mm.ply")); }) ==
          dir.file("mm.ply") + ": has 1.25e+07 m^2, more than the 20000 that can be compared; is it in metres?");
}

TEST_CASE("a mesh 3 cm off is 3 cm off, complete, and ICP takes the offset away") {
    const MeshEvaluation e = evaluate_mesh(whole_wall(3.03, 2.0), scene(), Se3{}, {});
    CHECK(e.area_m2 == Approx(16.0));
    CHECK(e.longest_side_m == Approx(0.25 * std::sqrt(2.0)));
    CHECK(e.seen_area_m2 == Approx(16.0).epsilon(0.02));
    const DistanceStatistics& a = e.by_trajectory.accuracy;
    CHECK(a.count == Approx(16000).epsilon(0.01));
    CHECK(a.median == Approx(0.03).margin(1e-4));
    CHECK(a.rmse == Approx(0.03).margin(1e-4));
    CHECK(a.within[1] == 0.0);                       // 2 cm
    CHECK(a.within[2] == Approx(1.0).margin(0.02));  // 5 cm
    CHECK(e.by_trajectory.completeness.within[2] == Approx(1.0).margin(0.02));
    CHECK(e.by_trajectory.f1(2) == Approx(1.0).margin(0.02));
    CHECK(e.icp_converged);
    CHECK(e.by_icp.accuracy.median < 1e-3);
    CHECK(e.overlap() == Approx(1.0).epsilon(0.02));
    CHECK(e.holes.planes == 1);
    CHECK(e.holes.share() == 0.0);
}

TEST_CASE("faces that bridge a step do not pull in ICP") {
    // Three walls of a room's corner, off by a centimetre and a bit, with a quarter of the first one a hand's breadth
    // before it.
    SceneTruth truth = scene();
    TriangleSoup mesh;
    const Vector3d off(0.01, -0.008, 0.006);
    const auto add = [](const TriangleSoup& part, const Vector3d& by, const auto& turned, TriangleSoup& soup) {
        const auto n = static_cast<int>(soup.vertices.size());
        for (const Vector3d& v : part.vertices) {
            soup.vertices.push_back(turned(v) + by);
        }
        for (const Eigen::Vector3i& t : part.triangles) {
            soup.triangles.push_back(t + Eigen::Vector3i::Constant(n));
        }
    };
    truth.surface = {};
    for (int axis = 0; axis < 3; ++axis) {
        const auto turned = [=](const Vector3d& v) {
            return Vector3d(v[(3 - axis) % 3], v[(4 - axis) % 3], v[(5 - axis) % 3]);
        };
        add(whole_wall(3.0, 2.0), Vector3d::Zero(), turned, truth.surface);
        add(whole_wall(3.0, 2.0), off, turned, mesh);
    }
    const auto bridge = wall(2.88, 2.0, 0.25, [](double y, double z) { return y < 0.0 || z < 0.0; });
    add(
        bridge, off, [](const Vector3d& v) { return v; }, mesh);
    const MeshEvaluation e = evaluate_mesh(mesh, truth, Se3{}, {});
    CHECK(e.icp_converged);
    CHECK((e.by_icp.T_true_est.p + off).norm() < 1e-3);  // 2 cm along x if they pull
    CHECK(e.by_icp.T_true_est.q.angularDistance(Eigen::Quaterniond::Identity()) < 1e-3);
    CHECK(e.by_icp.accuracy.median < 1e-3);
    CHECK(e.by_icp.accuracy.median < 0.2 * e.by_trajectory.accuracy.median);
    // 52 m^2 of mesh on 48 of wall: what is a hand's breadth before it covers nothing.
    CHECK(e.covered_m2 == Approx(48.0).epsilon(0.02));
    CHECK(e.overlap() == Approx(52.0 / 48.0).epsilon(0.02));
}

TEST_CASE("errors on large floors and walls are separated from those elsewhere") {
    SceneTruth truth = scene();
    CHECK(evaluate_mesh(whole_wall(3.03, 2.0), truth, Se3{}, {}).flat.count == 0);  // no one says how large it is
    truth.planes[0] = {"wall", truth.surface.normal(0), 3.0 * truth.surface.normal(0).x(), 16.0};
    // And a slanted triangle beside it.
    TriangleSoup mesh = whole_wall(3.03, 2.0);
    const auto first = static_cast<int>(truth.surface.vertices.size());
    for (const Vector3d& p : {Vector3d(3.0, 3.0, 0.0), Vector3d(3.5, 3.4, 0.0), Vector3d(3.0, 3.0, 1.0)}) {
        truth.surface.vertices.push_back(p);
        mesh.vertices.push_back(p + Vector3d(0.0, 0.01, 0.0));
    }
    truth.surface.triangles.push_back({first, first + 1, first + 2});
    mesh.triangles.push_back(truth.surface.triangles.back());
    const MeshEvaluation e = evaluate_mesh(mesh, truth, Se3{}, {});
    CHECK(e.flat.count == Approx(16000).epsilon(0.02));
    CHECK(e.flat.median == Approx(0.03).margin(1e-3));
    CHECK(e.uneven.count > 200);
    CHECK(e.uneven.median < 0.011);
    truth.planes[0].normal = (truth.planes[0].normal + Vector3d(0.0, 0.0, 0.2)).normalized();  // no wall any more
    CHECK(evaluate_mesh(mesh, truth, Se3{}, {}).flat.count == 0);
}

TEST_CASE("half a mesh is accurate and half complete; what is hidden or far need not be there") {
    SceneTruth truth = scene();
    const TriangleSoup half = wall(3.0, 2.0, 0.25, [](double y, double) { return y >= 0.0; });
    MeshEvaluation e = evaluate_mesh(half, truth, Se3{}, {});
    CHECK(e.by_trajectory.accuracy.p90 < 1e-6);
    CHECK(e.by_trajectory.completeness.within[0] == Approx(0.5).margin(0.02));
    // A screen in front of the missing half hides it; the screen itself is not in the mesh, but small.
    const TriangleSoup screen = wall(0.5, 0.4, 0.1, [](double y, double) { return y < -0.05; });
    const auto n = static_cast<int>(truth.surface.vertices.size());
    truth.surface.vertices.insert(truth.surface.vertices.end(), screen.vertices.begin(), screen.vertices.end());
    for (const Eigen::Vector3i& t : screen.triangles) {
        truth.surface.triangles.push_back(t + Eigen::Vector3i::Constant(n));
    }
    e = evaluate_mesh(half, truth, Se3{}, {});
    CHECK(e.by_trajectory.completeness.within[0] > 0.9);
    truth = scene();
    MeshEvalOptions near;
    near.seen_depth_m = 2.9;
    CHECK(evaluate_mesh(half, truth, Se3{}, near).seen_area_m2 == 0.0);
}

TEST_CASE("holes inside the mesh's outline count, gaps at its border do not") {
    const SceneTruth truth = scene();
    const auto missing = [](double y, double z) { return std::abs(y - 0.375) < 0.3 && std::abs(z) < 0.3; };
    const MeshEvaluation holed = evaluate_mesh(wall(3.0, 2.0, 0.25, missing), truth, Se3{}, {});
    CHECK(holed.holes.hole_m2 == Approx(0.5 * 0.75).epsilon(0.1));
    CHECK(holed.holes.covered_m2 == Approx(16.0 - 0.375).epsilon(0.03));
    const auto notch = [](double y, double z) { return std::abs(y - 0.375) < 0.3 && z > -0.3; };
    CHECK(evaluate_mesh(wall(3.0, 2.0, 0.25, notch), truth, Se3{}, {}).holes.hole_m2 == 0.0);
}

TEST_CASE("a crack does not make a hole part of the outside, a passage does, and planes that coincide count once") {
    SceneTruth truth = scene();
    truth.planes.push_back({"the same from behind", Vector3d(1.0, 0.0, 0.0), 3.005});
    const auto hole = [](double y, double z) { return std::abs(y - 0.025) < 0.3 && std::abs(z - 0.025) < 0.3; };
    const auto with_gap = [&](double width) {
        return wall(3.0, 2.0, 0.05,
                    [=](double y, double z) { return hole(y, z) || (z > 0.2 && y > -0.01 && y < width - 0.01); });
    };
    const double whole = evaluate_mesh(with_gap(0.0), truth, Se3{}, {}).holes.hole_m2;
    CHECK(whole == Approx(0.36).epsilon(0.1));
    const FlatHoles crack = evaluate_mesh(with_gap(0.05), truth, Se3{}, {}).holes;
    CHECK(crack.planes == 1);
    CHECK(crack.hole_m2 == Approx(whole + 0.05 * 1.65).epsilon(0.1));
    const FlatHoles passage = evaluate_mesh(with_gap(0.25), truth, Se3{}, {}).holes;
    CHECK(passage.hole_m2 == 0.0);
}

TEST_CASE("a scene's planes are read from the file beside it") {
    const test::TempDir folder;
    const TriangleSoup surface = whole_wall(3.0, 2.0);
    std::vector<Eigen::Vector3f> vertices;
    for (const Vector3d& v : surface.vertices) {
        vertices.push_back(v.cast<float>());
    }
    const std::string path = folder.file("scene.ply");
    REQUIRE(ok(write_ply(path, "", vertices, surface.triangles)));
    CHECK(load_scene(path, scene().camera, Se3{}, {}, 0.2).planes.empty());
    folder.write("planes.json", R"([{"name": "wall", "normal": [-1, 0, 0], "distance": -3}])");
    const SceneTruth truth = load_scene(path, scene().camera, Se3{}, {}, 0.2);
    REQUIRE(truth.surface.triangles.size() == surface.triangles.size());
    REQUIRE(truth.planes.size() == 1);
    CHECK(truth.planes[0].name == "wall");
    CHECK(truth.planes[0].distance == -3.0);
}

TEST_CASE("the tree finds the nearest point and what is in the way, as brute force does") {
    TriangleSoup soup;
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    const auto point = [&](double size) {
        const double x = size * uniform(random);
        const double y = size * uniform(random);
        return Vector3d(x, y, size * uniform(random));
    };
    for (int i = 0; i < 300; ++i) {
        const Vector3d centre = point(3.0);
        const auto n = static_cast<int>(soup.vertices.size());
        soup.vertices.insert(soup.vertices.end(), {centre + point(0.4), centre + point(0.4), centre + point(0.4)});
        soup.triangles.push_back({n, n + 1, n + 2});
    }
    const TriangleTree tree(soup);
    for (int i = 0; i < 300; ++i) {
        const Vector3d p = point(4.0);
        double best = 1e9;
        for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
            best = std::min(
                best, (p - nearest_on_triangle(p, soup.corner(t, 0), soup.corner(t, 1), soup.corner(t, 2))).norm());
            // No sample of the triangle may be nearer than the point said to be the nearest.
            const double u = std::abs(uniform(random));
            const double v = (1.0 - u) * std::abs(uniform(random));
            const Vector3d on = soup.corner(t, 0) + u * (soup.corner(t, 1) - soup.corner(t, 0)) +
                                v * (soup.corner(t, 2) - soup.corner(t, 0));
            REQUIRE((p - on).norm() >=
                    (p - nearest_on_triangle(p, soup.corner(t, 0), soup.corner(t, 1), soup.corner(t, 2))).norm() -
                        1e-12);
        }
        REQUIRE(tree.nearest(p, 100.0).distance == Approx(best));
        const Vector3d q = tree.nearest(p, 100.0).point;
        REQUIRE_FALSE(tree.blocks(p, q, 1e-6));  // nothing nearer is in the way of the nearest
        const auto t = static_cast<std::size_t>(i);
        const Vector3d middle = (soup.corner(t, 0) + soup.corner(t, 1) + soup.corner(t, 2)) / 3.0;
        REQUIRE(tree.blocks(p, middle + 0.1 * (middle - p), 0.0));  // a triangle is in the way of what is beyond it
        const double hit = tree.cast(p, middle - p, 2.0);
        REQUIRE(hit <= 1.0 + 1e-9);
        REQUIRE(tree.nearest(p + hit * (middle - p), 1.0).distance < 1e-9);  // on a triangle
        REQUIRE_FALSE(tree.blocks(p, p + 0.999 * hit * (middle - p), 0.0));  // and on the first one
        REQUIRE(tree.cast(p, Vector3d(0.0, 0.0, 1e-9), 1.0) == 1.0);         // nothing within reach
    }
}

}  // namespace
}  // namespace facet::mesh_accuracy_test
