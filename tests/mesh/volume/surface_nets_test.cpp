// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/volume/surface_nets.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "mesh/volume/tsdf_volume.h"
#include "tests/mesh/depth/stereo_scene.h"

namespace facet {
namespace {

constexpr int kSquare = 4;
constexpr int kColumns = test::kSceneWidth / kSquare;
constexpr int kRows = test::kSceneHeight / kSquare;

const SquareRaster& raster() {
    static const SquareRaster squares(test::scene_rig().left, kSquare, kColumns, kRows);
    return squares;
}

/// Each square shows n_W . p = d of the world, chosen by its column, as a camera at T_W_C sees it.
struct WorldPlane {
    Eigen::Vector3d n_W;
    double d = 0.0;
};
void look(TsdfVolume& volume, const std::function<WorldPlane(int column)>& plane_of, const Se3& T_W_C = {},
          float sigma = 0.002F) {
    std::vector<SurfacePatch> patches;
    for (int i = 0; i < kColumns * kRows; ++i) {
        const WorldPlane plane = plane_of(i % kColumns);
        const double from_camera = plane.d - plane.n_W.dot(T_W_C.p);
        patches.push_back({(T_W_C.q.conjugate() * plane.n_W / from_camera).cast<float>(), sigma});
    }
    volume.integrate(raster(), patches, T_W_C);
}

WorldPlane wall(double z) { return {Eigen::Vector3d::UnitZ(), z}; }

double area(const FusedMesh& mesh) {
    double sum = 0.0;
    for (const Eigen::Vector3i& t : mesh.triangles) {
        const auto p = [&](int k) { return mesh.vertices[static_cast<std::size_t>(t[k])]; };
        sum += 0.5 * static_cast<double>((p(1) - p(0)).cross(p(2) - p(0)).norm());
    }
    return sum;
}

TEST_CASE("a wall seen from two places is one surface, where it is, and faces the cameras") {
    const Eigen::Vector3d n = Eigen::Vector3d(0.2, -0.1, 1.0).normalized();
    TsdfVolume volume({});
    look(volume, [&](int) { return WorldPlane{n, 2.0}; });
    look(volume, [&](int) { return WorldPlane{n, 2.0}; }, {Eigen::Quaterniond::Identity(), {0.3, 0.1, 0.2}});
    const FusedMesh mesh = extract_surface(volume, {});
    REQUIRE(mesh.triangles.size() > 1000);
    for (const Eigen::Vector3f& v : mesh.vertices) {
        CHECK(std::abs(n.dot(v.cast<double>()) - 2.0) < 1e-4);
    }
    for (const Eigen::Vector3f& normal : mesh.normals) {
        CHECK(-n.dot(normal.cast<double>()) > 0.99);
    }
    CHECK(*std::max_element(mesh.observations.begin(), mesh.observations.end()) == 2);
    // 80 x 60 squares of 4 px at f = 240 px and 2 m, and a little more from the second place; no layer twice.
    CHECK(area(mesh) == Approx(2.67 * 2.0).epsilon(0.15));
}

TEST_CASE("surfaces that meet in sight only are not joined") {
    TsdfVolume volume({});
    look(volume, [](int column) { return wall(column < kColumns / 2 ? 1.5 : 2.5); });
    const FusedMesh mesh = extract_surface(volume, {});
    bool has_near = false;
    bool has_far = false;
    for (const Eigen::Vector3f& v : mesh.vertices) {
        const double near = std::abs(static_cast<double>(v.z()) - 1.5);
        const double far = std::abs(static_cast<double>(v.z()) - 2.5);
        CHECK(std::min(near, far) < 0.01);
        has_near |= near < 0.01;
        has_far |= far < 0.01;
    }
    CHECK(has_near);
    CHECK(has_far);
}

TEST_CASE("what later views see through is gone") {
    TsdfVolume volume({});
    look(volume, [](int) { return wall(1.5); });
    look(volume, [](int) { return wall(2.5); });
    look(volume, [](int) { return wall(2.5); });
    for (const Eigen::Vector3f& v : extract_surface(volume, {}).vertices) {
        CHECK(std::abs(v.z() - 2.5F) < 0.01F);
    }
}

TEST_CASE("one view that sees through outweighs five that do not") {
    TsdfVolume volume({});
    for (int i = 0; i < 5; ++i) {
        look(volume, [](int) { return wall(1.5); });
    }
    look(volume, [](int) { return wall(2.5); });
    for (const Eigen::Vector3f& v : extract_surface(volume, {}).vertices) {
        CHECK(std::abs(v.z() - 2.5F) < 0.01F);
    }
}

TEST_CASE("views weigh as their variances say, and uncertain surfaces are left out") {
    TsdfVolume volume({});
    look(
        volume, [](int) { return wall(2.0); }, {}, 0.001F);  // 4 mm at 2 m
    look(
        volume, [](int) { return wall(2.06); }, {}, 0.004F);  // 16 mm
    const double certain = 0.004 * 0.004 + 0.003 * 0.003;
    const double doubtful = 0.016 * 0.016 + 0.003 * 0.003;
    const double expected = (2.0 / certain + 2.06 / doubtful) / (1.0 / certain + 1.0 / doubtful);
    const FusedMesh mesh = extract_surface(volume, {});
    REQUIRE(!mesh.vertices.empty());
    for (const Eigen::Vector3f& v : mesh.vertices) {
        CHECK(std::abs(static_cast<double>(v.z()) - expected) < 0.006);  // weights fade behind each surface
    }
    SurfaceOptions strict;
    strict.max_sigma_m = 0.004;
    CHECK(extract_surface(volume, strict).triangles.empty());
}

TEST_CASE("a full volume keeps what it has and counts what it cannot take") {
    TsdfOptions options;
    options.max_blocks = 60;
    TsdfVolume volume(options);
    look(volume, [](int) { return wall(2.0); });
    CHECK(volume.block_count() == 60);
    CHECK(volume.refused() > 0);
    CHECK(!extract_surface(volume, {}).triangles.empty());
}

TEST_CASE("crumbs are left out") {
    TsdfVolume volume({});
    look(volume, [](int column) { return wall(column == 40 ? 1.2 : 2.5); });
    SurfaceOptions options;
    options.min_piece_m2 = 0.5;
    for (const Eigen::Vector3f& v : extract_surface(volume, options).vertices) {
        CHECK(v.z() > 2.4F);
    }
}

}  // namespace
}  // namespace facet
