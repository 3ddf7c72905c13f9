// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/volume/bare_surfaces.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "mesh/volume/tsdf_volume.h"
#include "tests/mesh/depth/stereo_scene.h"
#include "tests/mesh/volume/whole_surface.h"
#include "tests/support/allocation_guard.h"

namespace facet::bare_surfaces_test {
namespace {

constexpr SquareLayout kLayout{4, test::kSceneWidth / 4, test::kSceneHeight / 4, 1.0 / 80.0};

const SquareRaster& raster() {
    static const SquareRaster squares(test::scene_rig().left, kLayout.side_px, kLayout.columns, kLayout.rows);
    return squares;
}

/// An evenly grey image, in which squares within the frame are bare, and others have patches of a plane.
struct Scene {
    std::vector<std::uint8_t> pixels =
        std::vector<std::uint8_t>(std::size_t{test::kSceneWidth} * test::kSceneHeight, 120);
    std::vector<SurfacePatch> patches = std::vector<SurfacePatch>(std::size_t(kLayout.columns) * kLayout.rows);

    /// @param plane_of  n of each square, zero where nothing is known
    explicit Scene(const std::function<Eigen::Vector3f(int column, int row)>& plane_of) {
        for (int i = 0; i < kLayout.columns * kLayout.rows; ++i) {
            const Eigen::Vector3f n = plane_of(i % kLayout.columns, i / kLayout.columns);
            patches[static_cast<std::size_t>(i)] = {n, n.isZero() ? 0.0F : 0.002F};
        }
    }
    void fill() {
        const ImageView image{pixels.data(), test::kSceneWidth, test::kSceneHeight, test::kSceneWidth};
        BareSurfaces bare(raster(), kLayout);
        const test::AllocationGuard guard;
        bare.begin(image, patches);
        while (bare.advance(100)) {
        }
        const std::uint64_t allocations = guard.allocations();
        CHECK(allocations == 0);
    }
    const SurfacePatch& at(int column, int row) const {
        return patches[static_cast<std::size_t>(row * kLayout.columns + column)];
    }
    auto inferred() const {
        return std::ranges::count_if(patches, [](const SurfacePatch& p) { return p.is_inferred; });
    }
};

const Eigen::Vector3f kWall(0.05F, 0.1F, 0.4F);
const Eigen::Vector3f kNothing = Eigen::Vector3f::Zero();
bool is_inside(int column, int row) { return column >= 20 && column < 60 && row >= 15 && row < 45; }

TEST_CASE("a bare wall between pictures of one plane is that plane") {
    Scene scene([](int column, int row) { return is_inside(column, row) ? kNothing : kWall; });
    scene.fill();
    CHECK(scene.inferred() == 40 * 30);
    const SurfacePatch& middle = scene.at(40, 30);
    REQUIRE(middle.is_inferred);
    CHECK((middle.n_C - kWall).norm() < 1e-3F);
    CHECK(middle.sigma >= 0.25F / 80.0F);
    CHECK(!scene.at(10, 30).is_inferred);
}

TEST_CASE("two lines to either side are evidence, one is not") {
    Scene between([](int column, int) { return column / 3 == 5 || column / 3 == 20 ? kWall : kNothing; });
    between.fill();
    CHECK(between.at(40, 30).is_inferred);
    CHECK(!between.at(5, 30).exists());
    CHECK(!between.at(75, 30).exists());
    Scene beside([](int column, int) { return column / 3 == 5 ? kWall : kNothing; });
    beside.fill();
    CHECK(beside.inferred() == 0);
}

TEST_CASE("a wall too far away to be known well is not inferred") {
    Scene scene([](int column, int row) { return is_inside(column, row) ? kNothing : Eigen::Vector3f(0.5F * kWall); });
    scene.fill();
    CHECK(scene.inferred() == 0);
}

TEST_CASE("no plane goes on across a step in grey") {
    Scene scene([](int column, int) { return column / 3 == 5 || column / 3 == 20 ? kWall : kNothing; });
    for (std::size_t i = 0; i < scene.pixels.size(); ++i) {
        scene.pixels[i] = i % test::kSceneWidth < 160 ? 120 : 135;
    }
    scene.fill();
    CHECK(scene.inferred() == 0);
}

TEST_CASE("between two boards before a wall is the wall") {
    const Eigen::Vector3f board(0.0F, 0.0F, 0.8F);
    Scene scene([&](int column, int row) {
        return is_inside(column, row) ? kNothing : (column < 20 || column >= 60 ? board : kWall);
    });
    scene.fill();
    const SurfacePatch& middle = scene.at(40, 30);
    REQUIRE(middle.is_inferred);
    CHECK((middle.n_C - kWall).norm() < 1e-3F);
}

TEST_CASE("what lies scattered around is no plane") {
    Scene scene([](int column, int row) {
        return is_inside(column, row)
                   ? kNothing
                   : Eigen::Vector3f(0.0F, 0.0F, 0.3F + 0.1F * static_cast<float>((column * 7 + row * 5) % 9));
    });
    scene.fill();
    CHECK(scene.inferred() == 0);
}

TEST_CASE("an inferred surface is one, and sees through nothing; nor do far ones count") {
    const auto wall = [](double z, bool is_inferred) {
        Scene scene([&](int, int) { return Eigen::Vector3f(0.0F, 0.0F, static_cast<float>(1.0 / z)); });
        for (SurfacePatch& patch : scene.patches) {
            patch.is_inferred = is_inferred;
        }
        return scene.patches;
    };
    TsdfOptions options;
    options.max_depth_m = 2.5;
    TsdfVolume volume(options);
    const auto most = [&](auto field) {
        int value = 0;
        for (std::size_t b = 0; b < volume.slot_end(); ++b) {
            for (const Voxel& voxel : volume.block(b).voxels) {
                value = std::max(value, static_cast<int>(field(voxel)));
            }
        }
        return value;
    };
    const auto through = [](const Voxel& v) { return v.views > 0 ? v.through : 0; };
    volume.integrate(raster(), wall(1.5, false), {});
    volume.integrate(raster(), wall(2.0, true), {});
    CHECK(most(through) == 0);
    CHECK(!test::whole_surface(volume).triangles.empty());
    const std::size_t blocks = volume.block_count();
    volume.integrate(raster(), wall(3.0, false), {});  // beyond what counts, but not without seeing
    CHECK(volume.block_count() == blocks);
    CHECK(most(through) == 1);
}

}  // namespace
}  // namespace facet::bare_surfaces_test
