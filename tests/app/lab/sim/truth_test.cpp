// SPDX-License-Identifier: BSD-2-Clause
// The truth that is written: triangles on the surfaces, planes with their normals into the free space.
#include "app/lab/sim/truth.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "app/lab/eval/plane_file.h"
#include "tests/app/lab/sim/draft_scene.h"
#include "tests/support/temp_dir.h"

namespace facet::sim::truth_test {
namespace {

TEST_CASE("Vertices of the tessellation lie on the surfaces, facets within the sagitta") {
    for (const std::string_view name : scene_names()) {
        const Scene& scene = draft_scene(name);
        const TriangleMesh mesh = tessellate(scene, 0.002);
        REQUIRE(mesh.triangles.size() > scene.shapes().size() / 2);
        double worst_vertex = 0.0;
        double worst_centre = 0.0;
        for (std::size_t i = 0; i < mesh.triangles.size(); i += 23) {
            Eigen::Vector3d centre = Eigen::Vector3d::Zero();
            for (int k = 0; k < 3; ++k) {
                const Eigen::Vector3d p = mesh.vertices[static_cast<std::size_t>(mesh.triangles[i][k])].cast<double>();
                worst_vertex = std::max(worst_vertex, scene.clearance(p, 1.0));
                centre += p / 3.0;
            }
            worst_centre = std::max(worst_centre, scene.clearance(centre, 1.0));
        }
        CHECK(worst_vertex < 1e-5);
        CHECK(worst_centre < 0.005);
    }
}

TEST_CASE("The tessellation has the area of the surfaces") {
    const Scene& scene = draft_scene("room");
    double expected = 0.0;
    for (const SurfaceShape& s : scene.shapes()) {
        expected += surface_area(s);
    }
    const TriangleMesh mesh = tessellate(scene, 0.0005);
    double area = 0.0;
    for (const Eigen::Vector3i& t : mesh.triangles) {
        const Eigen::Vector3f a = mesh.vertices[static_cast<std::size_t>(t[0])];
        const Eigen::Vector3f b = mesh.vertices[static_cast<std::size_t>(t[1])];
        const Eigen::Vector3f c = mesh.vertices[static_cast<std::size_t>(t[2])];
        area += 0.5 * static_cast<double>((b - a).cross(c - a).norm());
    }
    CHECK(area == Approx(expected).epsilon(0.003));
}

TEST_CASE("Planes of the room: the shell faces inwards, pictures belong to their wall") {
    const Scene& scene = draft_scene("room");
    const std::vector<TruePlane> planes = true_planes(scene, {});
    const Eigen::Vector3d middle(0.0, 0.0, 1.6);
    int shell = 0;
    for (const TruePlane& p : planes) {
        CHECK(p.normal.norm() == Approx(1.0));
        CHECK(std::abs(p.normal.dot(p.centroid) - p.distance) < 0.025);
        if (p.name == "floor" || p.name == "ceiling" || p.name.rfind("wall.", 0) == 0) {
            ++shell;
            CHECK(p.normal.dot(middle) > p.distance + 1.0);
        }
        CHECK(p.name != "picture");
    }
    CHECK(shell == 6);
}

TEST_CASE("Boxes face outwards") {
    const Scene& scene = draft_scene("room");
    for (const Surface& s : scene.surfaces()) {
        if (s.name == "cabinet.top" || s.name == "cabinet.back" || s.name == "cabinet.right" || s.name == "table.top") {
            const Eigen::Vector3d centre = surface_point(s.shape, 0.5, 0.5);
            CHECK(scene.cast(centre + 0.5 * surface_normal(s.shape, 0.5, 0.5), -surface_normal(s.shape, 0.5, 0.5))
                      .distance > 0.1);
            CHECK(surface_normal(s.shape, 0.5, 0.5).dot(Eigen::Vector3d(0.0, 0.0, 1.6) - centre) > -1.0);
        }
    }
}

TEST_CASE("Seen area counts the cells that were hit, each once") {
    const Scene& scene = draft_scene("room");
    int floor = -1;
    for (std::size_t i = 0; i < scene.surfaces().size(); ++i) {
        floor = scene.surfaces()[i].name == "floor" ? static_cast<int>(i) : floor;
    }
    REQUIRE(floor >= 0);
    const std::vector<CoarseHit> hits{{floor, 0.5F, 0.5F}, {floor, 0.5F, 0.5F}, {floor, 0.9F, 0.1F}, {-1, 0.0F, 0.0F}};
    const std::vector<TruePlane> planes = true_planes(scene, hits);
    REQUIRE(planes.front().name == "floor");
    CHECK(planes.front().seen_area == Approx(0.02).epsilon(0.1));
    CHECK(planes[1].seen_area == 0.0);
}

TEST_CASE("The planes that are written are read back as they are") {
    const Scene& scene = draft_scene("room");
    const std::vector<CoarseHit> hits{{0, 0.5F, 0.5F}};
    const test::TempDir folder;
    std::string failed;
    REQUIRE(ok(write_truth(folder.path(), scene, hits, "{}", failed)));
    const std::vector<TruePlane> expected = true_planes(scene, hits);
    const std::vector<EvalPlane> planes = load_planes(folder.file("truth/planes.json"));
    REQUIRE(planes.size() == expected.size());
    for (std::size_t i = 0; i < planes.size(); ++i) {
        CHECK(planes[i].name == expected[i].name);
        CHECK(planes[i].normal == expected[i].normal);
        CHECK(planes[i].distance == expected[i].distance);
        CHECK(planes[i].seen_m2 == expected[i].seen_area);
    }
    const std::string text = test::read_file(folder.file("truth/planes.json"));
    for (const char* kind : {"horizontal", "vertical"}) {
        CHECK_THAT(text, Catch::Contains(std::string("\"kind\": \"") + kind + "\""));
    }
}

}  // namespace
}  // namespace facet::sim::truth_test
