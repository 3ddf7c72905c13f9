// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/epipolar_scan.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>

#include "estimator/frontend/patch_aligner.h"
#include "tests/estimator/frontend/synthetic.h"

namespace facet::epipolar_scan_test {
namespace {

constexpr int kWidth = 200;
constexpr int kHeight = 140;

ImagePyramid pyramid_of(const synthetic::Image& image) {
    ImagePyramid pyramid;
    REQUIRE(ok(pyramid.configure(image.width, image.height, 1)));
    pyramid.build(image.view());
    return pyramid;
}

/// A slightly bent curve of unit steps that passes through `through` at place `index`.
CurveStretch curve(const Eigen::Vector2f& through, const Eigen::Vector2f& along, const Eigen::Matrix2f& A, int count,
                   float index, float bend) {
    const Eigen::Vector2f normal(-along.y(), along.x());
    const auto at = [&](float i) {
        const float t = (i - index) / static_cast<float>(count);
        return Eigen::Vector2f(through + (i - index) * along + bend * t * t * normal);
    };
    return {at(0.0F), at(0.5F * static_cast<float>(count)), at(static_cast<float>(count)), A, count};
}

}  // namespace

TEST_CASE("a scan finds the place that the patch has come to, turned and scaled", "[frontend]") {
    const double angle = GENERATE(0.0, 0.5, 1.6);
    const double scale = GENERATE(0.9, 1.1);
    const Eigen::Matrix2d A = scale * Eigen::Rotation2Dd(angle).toRotationMatrix();
    const synthetic::Texture texture(9.0, 40.0, 5);
    const ImagePyramid first = pyramid_of(synthetic::warp(texture, kWidth, kHeight, {0.0, 0.0}));
    const ImagePyramid second = pyramid_of(synthetic::warp(texture, kWidth, kHeight, {4.3, -2.6}, A));
    const Eigen::Vector2d c(0.5 * (kWidth - 1), 0.5 * (kHeight - 1));
    const Eigen::Vector2d at = c + Eigen::Vector2d(6.4, -3.7);
    const Eigen::Vector2d truth = A * (at - c) + c + Eigen::Vector2d(4.3, -2.6);
    EpipolarScan scan;
    scan.configure(15);
    PatchAligner aligner;
    REQUIRE(ok(aligner.configure(15, 1, 20, 0.01)));
    PatchTemplate patch;
    aligner.allocate(patch);
    REQUIRE(ok(aligner.extract(first, at, {0, false}, patch)));
    for (const Eigen::Vector2f& along : {Eigen::Vector2f(1.0F, 0.0F), Eigen::Vector2f(-0.6F, 0.8F)}) {
        const CurveStretch stretch = curve(truth.cast<float>(), along, A.cast<float>(), 30, 13.0F, 1.5F);
        REQUIRE(EpipolarScan::suits(stretch));
        std::array<float, CurveStretch::kMaxPlaces> scores{};
        scan.correlate(first.pairs(0), at.cast<float>(), second.pairs(0), stretch, scores.data());
        CAPTURE(angle, scale, along.transpose());
        CHECK(std::max_element(scores.begin(), scores.begin() + 30) - scores.begin() == 13);
        CHECK(scores[13] > 0.98F);
        // Beside the best place too, the scores are about those of the patch interpolated there: its disc is scaled by
        // A, the strip's is not.
        for (int i = 0; i < 30; ++i) {
            const float t = static_cast<float>(i - 13) / 30.0F;
            const Eigen::Vector2f place = truth.cast<float>() + static_cast<float>(i - 13) * along +
                                          1.5F * t * t * Eigen::Vector2f(-along.y(), along.x());
            const float exact = aligner.correlate(patch, second, 0, {A.cast<float>(), place.cast<double>()});
            CHECK(std::abs(scores[static_cast<std::size_t>(i)] - exact) < 0.15F);
        }
    }
}

TEST_CASE("a place's score depends neither on how many others are asked for nor on how near the border is",
          "[frontend]") {
    const int window = GENERATE(9, 15);
    const synthetic::Texture texture(9.0, 40.0, 5);
    const ImagePyramid first = pyramid_of(synthetic::warp(texture, kWidth, kHeight, {0.0, 0.0}));
    const ImagePyramid second = pyramid_of(synthetic::warp(texture, kWidth, kHeight, {4.25, -2.5}));
    const RowPairs& all = second.pairs(0);
    const Eigen::Vector2f at(100.5F, 70.25F);
    const Eigen::Vector2f begin(92.0F, 67.75F);
    const auto scan_from = [&](const RowPairs& image, const Eigen::Vector2f& place, int count) {
        EpipolarScan scan;
        scan.configure(window);
        std::array<float, CurveStretch::kMaxPlaces> scores{};
        const CurveStretch line = curve(place, {1.0F, 0.0F}, Eigen::Matrix2f::Identity(), count, 0.0F, 0.0F);
        scan.correlate(first.pairs(0), at, image, line, scores.data());
        return scores;
    };
    const auto expected = scan_from(all, begin, CurveStretch::kMaxPlaces);
    for (int count = 2; count < CurveStretch::kMaxPlaces; ++count) {
        // An image that ends where the last place's window does, but for half a pixel.
        const int reach = window / 2;
        const int left = static_cast<int>(begin.x()) - reach;
        const int top = static_cast<int>(begin.y()) - reach;
        const RowPairs cut{all.data + top * all.stride + left, 2 * reach + count + 1, 2 * reach + 3, all.stride};
        const auto scores = scan_from(all, begin, count);
        const auto beside =
            scan_from(cut, begin - Eigen::Vector2f(static_cast<float>(left), static_cast<float>(top)), count);
        for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
            CAPTURE(window, count, i);
            REQUIRE(expected[i] > -1.0F);
            CHECK(std::abs(scores[i] - expected[i]) < 1e-3F);
            CHECK(std::abs(beside[i] - expected[i]) < 1e-3F);
        }
    }
}

TEST_CASE("a scan scores nothing outside the image or without texture", "[frontend]") {
    const synthetic::Texture texture(9.0, 40.0, 6);
    const ImagePyramid image = pyramid_of(synthetic::warp(texture, kWidth, kHeight, {0.0, 0.0}));
    const ImagePyramid blank = pyramid_of(synthetic::Image(kWidth, kHeight, 90));
    EpipolarScan scan;
    scan.configure(15);
    std::array<float, CurveStretch::kMaxPlaces> scores{};
    const Eigen::Vector2f at(60.0F, 70.0F);
    // Runs out of the image at its right border: the patch's last place is 7 px inside.
    const CurveStretch out =
        curve({static_cast<float>(kWidth - 1), 70.0F}, {1.0F, 0.0F}, Eigen::Matrix2f::Identity(), 32, 20.0F, 0.0F);
    scan.correlate(image.pairs(0), at, image.pairs(0), out, scores.data());
    for (int i = 0; i < 32; ++i) {
        CAPTURE(i);
        CHECK((scores[static_cast<std::size_t>(i)] == -1.0F) == (i >= 13));
    }
    const CurveStretch in = curve(at, {1.0F, 0.0F}, Eigen::Matrix2f::Identity(), 17, 5.0F, 0.0F);
    scores.fill(2.0F);
    scan.correlate(image.pairs(0), at, blank.pairs(0), in, scores.data());
    CHECK(std::all_of(scores.begin(), scores.begin() + 17, [](float s) { return s == -1.0F; }));
    CHECK(scores[17] == 2.0F);
    scan.correlate(blank.pairs(0), at, image.pairs(0), in, scores.data());
    CHECK(std::all_of(scores.begin(), scores.begin() + 17, [](float s) { return s == -1.0F; }));
}

TEST_CASE("a scan refuses places that are not about a pixel apart", "[frontend]") {
    const Eigen::Matrix2f I = Eigen::Matrix2f::Identity();
    CHECK(EpipolarScan::suits({{0.0F, 0.0F}, {16.0F, 0.0F}, {32.0F, 0.0F}, I, 32}));
    CHECK(!EpipolarScan::suits({{0.0F, 0.0F}, {16.0F, 0.0F}, {32.0F, 0.0F}, I, 33}));
    CHECK(!EpipolarScan::suits({{0.0F, 0.0F}, {16.0F, 0.0F}, {32.0F, 0.0F}, I, 0}));
    CHECK(!EpipolarScan::suits({{0.0F, 0.0F}, {5.0F, 0.0F}, {32.0F, 0.0F}, I, 32}));
    CHECK(!EpipolarScan::suits({{0.0F, 0.0F}, {60.0F, 0.0F}, {120.0F, 0.0F}, I, 32}));
    CHECK(!EpipolarScan::suits({{0.0F, 0.0F}, {16.0F, 0.0F}, {32.0F, 0.0F}, 0.1F * I, 32}));
    const float nan = std::nanf("");
    CHECK(!EpipolarScan::suits({{0.0F, 0.0F}, {16.0F, nan}, {32.0F, 0.0F}, I, 32}));
}

}  // namespace facet::epipolar_scan_test
