// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/volume/surface_nets.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

#include "mesh/volume/tsdf_volume.h"
#include "tests/mesh/depth/stereo_scene.h"
#include "tests/mesh/volume/whole_surface.h"
#include "tests/support/allocation_guard.h"

namespace facet::surface_nets_test {
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
        patches.push_back({(T_W_C.q.conjugate() * plane.n_W / from_camera).cast<float>(), sigma, false, 77.0F});
    }
    volume.integrate(raster(), patches, T_W_C);
}

WorldPlane wall(double z) { return {Eigen::Vector3d::UnitZ(), z}; }

TEST_CASE("a wall seen from two places is one surface, where it is, and faces the cameras") {
    const Eigen::Vector3d n = Eigen::Vector3d(0.2, -0.1, 1.0).normalized();
    TsdfVolume volume({});
    look(volume, [&](int) { return WorldPlane{n, 2.0}; });
    look(volume, [&](int) { return WorldPlane{n, 2.0}; }, {Eigen::Quaterniond::Identity(), {0.3, 0.1, 0.2}});
    const test::WholeSurface mesh = test::whole_surface(volume);
    REQUIRE(mesh.triangles.size() > 1000);
    for (const SurfaceVertex& v : mesh.vertices) {
        CHECK(std::abs(n.dot(v.p_W.cast<double>()) - 2.0) < 1e-4);
    }
    const auto turned = std::ranges::count_if(
        mesh.vertices, [&](const SurfaceVertex& v) { return -n.dot(v.normal_W.cast<double>()) < 0.99; });
    CHECK(turned < std::ssize(mesh.vertices) / 50);  // at the border, where there are no voxels along the normal
    for (const SurfaceVertex& v : mesh.vertices) {
        CHECK(v.grey == Approx(77.0F).margin(0.5));
        CHECK(v.sigma_m > 0.0F);
    }
    CHECK(mesh.views == 2);
    CHECK(mesh.apart_m == 0.0F);
    // 80 x 60 squares of 4 px at f = 240 px and 2 m, and a little more from the second place; no layer twice.
    CHECK(mesh.area() == Approx(2.67 * 2.0).epsilon(0.15));
}

TEST_CASE("surfaces that meet in sight only are not joined") {
    TsdfVolume volume({});
    look(volume, [](int column) { return wall(column < kColumns / 2 ? 1.5 : 2.5); });
    const test::WholeSurface mesh = test::whole_surface(volume);
    bool has_near = false;
    bool has_far = false;
    for (const SurfaceVertex& v : mesh.vertices) {
        const double near = std::abs(static_cast<double>(v.p_W.z()) - 1.5);
        const double far = std::abs(static_cast<double>(v.p_W.z()) - 2.5);
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
    for (const SurfaceVertex& v : test::whole_surface(volume).vertices) {
        CHECK(std::abs(v.p_W.z() - 2.5F) < 0.01F);
    }
}

TEST_CASE("one view that sees through outweighs five that do not") {
    TsdfVolume volume({});
    for (int i = 0; i < 5; ++i) {
        look(volume, [](int) { return wall(1.5); });
    }
    look(volume, [](int) { return wall(2.5); });
    for (const SurfaceVertex& v : test::whole_surface(volume).vertices) {
        CHECK(std::abs(v.p_W.z() - 2.5F) < 0.01F);
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
    const test::WholeSurface mesh = test::whole_surface(volume);
    REQUIRE(!mesh.vertices.empty());
    for (const SurfaceVertex& v : mesh.vertices) {
        CHECK(std::abs(static_cast<double>(v.p_W.z()) - expected) < 0.006);  // weights fade behind each surface
    }
    SurfaceOptions strict;
    strict.max_sigma_m = 0.004;
    CHECK(test::whole_surface(volume, strict).triangles.empty());
}

TEST_CASE("a full volume keeps what it has and counts what it cannot take") {
    TsdfOptions options;
    options.max_blocks = 60;
    TsdfVolume volume(options);
    look(volume, [](int) { return wall(2.0); });
    CHECK(volume.block_count() == 60);
    CHECK(volume.refused() > 0);
    CHECK(!test::whole_surface(volume).triangles.empty());
}

TEST_CASE("the farthest blocks make room, and the others are found as before") {
    TsdfOptions options;
    options.max_blocks = 300;
    TsdfVolume volume(options);
    look(volume, [](int) { return wall(1.0); });
    const std::size_t before = volume.block_count();
    REQUIRE(before > 40);
    REQUIRE(volume.refused() == 0);
    const Eigen::Vector3d corner(-0.6, -0.4, 1.0);
    volume.make_room(corner, 300 - before + 20);
    CHECK(volume.block_count() == before - 20);
    CHECK(volume.left() == 20);
    double farthest = 0.0;
    for (std::size_t slot = 0; slot < volume.slot_end(); ++slot) {
        const TsdfVolume::Block& block = volume.block(slot);
        if (block.is_used) {
            CHECK(volume.find(block.at) == static_cast<int>(slot));
            farthest = std::max(farthest, (0.32 * (block.at.cast<double>().array() + 0.5).matrix() - corner).norm());
        } else {
            CHECK(volume.find(block.at) == -1);
            CHECK((0.32 * (block.at.cast<double>().array() + 0.5).matrix() - corner).norm() >= farthest - 1e-9);
        }
    }
    look(volume, [](int) { return wall(1.0); });
    CHECK(volume.block_count() == before);
    volume.clear();
    CHECK(volume.block_count() == 0);
    CHECK(volume.find({0, 0, 3}) == -1);
}

TEST_CASE("a view in parts is the view, and no heap") {
    TsdfVolume whole({});
    TsdfVolume parts({});
    const std::vector<SurfacePatch> patches(std::size_t{kColumns} * kRows, {{0.05F, 0.1F, 0.5F}, 0.002F, false, 9.0F});
    whole.integrate(raster(), patches, {});
    int steps = 0;
    const test::AllocationGuard guard;
    parts.begin(raster(), patches, {}, 1);
    while (parts.add_blocks(7)) {
        ++steps;
    }
    while (parts.update_blocks(1)) {
        ++steps;
    }
    const std::uint64_t allocations = guard.allocations();
    CHECK(allocations == 0);
    CHECK(steps > 700);
    REQUIRE(parts.block_count() == whole.block_count());
    for (std::size_t slot = 0; slot < whole.slot_end(); ++slot) {
        CHECK(std::memcmp(whole.block(slot).voxels.data(), parts.block(slot).voxels.data(),
                          sizeof(whole.block(slot).voxels)) == 0);
    }
}

TEST_CASE("poses and patches that are NaN leave no trace") {
    TsdfVolume volume({});
    look(volume, [](int) { return wall(2.0); });
    const auto before = test::whole_surface(volume);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float inf = std::numeric_limits<float>::infinity();
    for (const SurfacePatch& bad :
         {SurfacePatch{{nan, 0.0F, 0.5F}, 0.002F}, SurfacePatch{{0.0F, 0.0F, inf}, 0.002F},
          SurfacePatch{{0.0F, 0.0F, 0.5F}, inf}, SurfacePatch{{0.0F, 0.0F, 1e-30F}, 1e-30F}}) {
        volume.integrate(raster(), std::vector<SurfacePatch>(std::size_t{kColumns} * kRows, bad), {});
    }
    const std::vector<SurfacePatch> good(std::size_t{kColumns} * kRows, {{0.0F, 0.0F, 0.5F}, 0.002F});
    volume.integrate(raster(), good, {Eigen::Quaterniond::Identity(), {std::nan(""), 0.0, 0.0}});
    volume.integrate(raster(), good, {Eigen::Quaterniond::Identity(), {1e300, 0.0, 0.0}});
    const auto after = test::whole_surface(volume);
    REQUIRE(after.vertices.size() == before.vertices.size());
    for (std::size_t i = 0; i < after.vertices.size(); ++i) {
        CHECK(after.vertices[i].p_W == before.vertices[i].p_W);
    }
}

}  // namespace
}  // namespace facet::surface_nets_test
