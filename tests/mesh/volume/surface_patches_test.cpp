// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/volume/surface_patches.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>

#include "tests/mesh/depth/stereo_scene.h"

namespace facet::surface_patches_test {
namespace {

constexpr int kSquare = 4;
constexpr int kColumns = test::kSceneWidth / kSquare;
constexpr int kRows = test::kSceneHeight / kSquare;
constexpr double kPerPx = 1.0 / 24.0;  // f = 240 px, 0.1 m apart

const SquareRaster& raster() {
    static const SquareRaster squares(test::scene_rig().left, kSquare, kColumns, kRows);
    return squares;
}

/// Samples in the squares' middles; 0 is none.
std::vector<DepthSample> samples_of(const std::function<double(int column, int row, const Eigen::Vector2d& xy)>& rho) {
    std::vector<DepthSample> samples(std::size_t{kColumns} * kRows);
    for (int i = 0; i < kColumns * kRows; ++i) {
        DepthSample& s = samples[static_cast<std::size_t>(i)];
        s.xy = raster().middle(static_cast<std::size_t>(i));
        s.inverse_depth = static_cast<float>(rho(i % kColumns, i / kColumns, s.xy.cast<double>()));
        s.sigma = static_cast<float>(0.2 * kPerPx);
    }
    return samples;
}

std::vector<SurfacePatch> patches_of(const std::vector<DepthSample>& samples) {
    const SquareLayout layout{kSquare, kColumns, kRows, kPerPx};
    std::vector<SurfacePatch> patches;
    for (int i = 0; i < layout.count(); ++i) {
        patches.push_back(fit_patch(samples, layout, i));
    }
    return patches;
}

const SurfacePatch& at(const std::vector<SurfacePatch>& patches, int column, int row) {
    return patches[static_cast<std::size_t>(row * kColumns + column)];
}

TEST_CASE("every square of the image is found by its ray") {
    for (int i = 0; i < kColumns * kRows; ++i) {
        const Eigen::Vector2f& xy = raster().middle(static_cast<std::size_t>(i));
        CHECK(raster().square_at(xy.x(), xy.y()) == i);
    }
    CHECK(raster().square_at(2.0F, 0.0F) == -1);
    CHECK(raster().square_at(0.0F, -2.0F) == -1);
}

TEST_CASE("patches have the plane's slope and are more certain than their samples") {
    const Eigen::Vector3d n(0.1, 0.3, 0.5);
    const auto patches =
        patches_of(samples_of([&](int, int, const Eigen::Vector2d& xy) { return n.dot(xy.homogeneous()); }));
    for (int i = 0; i < kColumns * kRows; ++i) {
        if (i % kColumns < 2 || i % kColumns >= kColumns - 2 || i / kColumns < 2 || i / kColumns >= kRows - 2) {
            continue;  // at the border samples are on one side only
        }
        const SurfacePatch& patch = patches[static_cast<std::size_t>(i)];
        REQUIRE(patch.exists());
        CHECK((patch.n_C.cast<double>() - n).norm() < 0.02);
        CHECK(patch.sigma < static_cast<float>(0.2 * kPerPx));
    }
}

TEST_CASE("no patch bridges a step") {
    const auto patches = patches_of(samples_of(
        [](int column, int, const Eigen::Vector2d&) { return column < kColumns / 2 ? 1.0 / 1.5 : 1.0 / 2.5; }));
    for (int column = 2; column < kColumns - 2; ++column) {
        const SurfacePatch& patch = at(patches, column, kRows / 2);
        const bool is_at_step = column == kColumns / 2 - 1 || column == kColumns / 2;
        REQUIRE((patch.exists() || is_at_step));
        if (!patch.exists()) {
            continue;
        }
        CHECK(1.0 / static_cast<double>(patch.n_C.z()) == Approx(column < kColumns / 2 ? 1.5 : 2.5).epsilon(0.02));
        CHECK(patch.n_C.head<2>().norm() < 0.02F);
    }
}

TEST_CASE("a gap is closed from all around, not from one side") {
    const auto patches = patches_of(samples_of([](int column, int row, const Eigen::Vector2d&) {
        const bool is_gap = (column == 20 && row == 20) || column >= 60;
        return is_gap ? 0.0 : 0.5;
    }));
    CHECK(at(patches, 20, 20).exists());
    CHECK(at(patches, 58, 20).exists());
    CHECK(!at(patches, 60, 20).exists());
    CHECK(!at(patches, 61, 20).exists());
}

TEST_CASE("NaN makes no patch that is NaN") {
    auto samples = samples_of([](int, int, const Eigen::Vector2d&) { return 0.5; });
    for (std::size_t i = 0; i < samples.size(); i += 7) {
        samples[i].inverse_depth = std::numeric_limits<float>::quiet_NaN();
        samples[(i + 3) % samples.size()].sigma = std::numeric_limits<float>::quiet_NaN();
        samples[(i + 5) % samples.size()].inverse_depth = std::numeric_limits<float>::infinity();
    }
    for (const SurfacePatch& patch : patches_of(samples)) {
        CHECK((!patch.exists() || (patch.n_C.allFinite() && std::isfinite(patch.sigma))));
    }
}

TEST_CASE("a sample that disagrees with all around it has no patch") {
    const auto patches = patches_of(
        samples_of([](int column, int row, const Eigen::Vector2d&) { return column == 30 && row == 30 ? 1.2 : 0.5; }));
    CHECK(!at(patches, 30, 30).exists());
    CHECK(at(patches, 31, 30).exists());
}

}  // namespace
}  // namespace facet::surface_patches_test
