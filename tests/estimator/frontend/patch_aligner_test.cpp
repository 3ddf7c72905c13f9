// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/patch_aligner.h"

#include <catch2/catch.hpp>

#include "tests/estimator/frontend/synthetic.h"

namespace facet::patch_aligner_test {

using synthetic::Texture;

namespace {

constexpr int kWidth = 160;
constexpr int kHeight = 120;
constexpr int kLevels = 3;

ImagePyramid pyramid_of(const synthetic::Image& image) {
    ImagePyramid pyramid;
    REQUIRE(ok(pyramid.configure(image.width, image.height, kLevels)));
    pyramid.build(image.view());
    return pyramid;
}

/// Largest and mean error over a grid of points, when aligning an image with its warped version from `guess_error` off.
struct Errors {
    double worst = 0.0;
    double mean = 0.0;
    int failed = 0;
    int points = 0;
};

Errors align_all(const Texture& texture, const Eigen::Vector2d& shift, const Eigen::Matrix2d& A, double gain,
                 double offset, bool affine, const Eigen::Vector2d& guess_error, const Eigen::Vector2d& sub_pixel) {
    const ImagePyramid first = pyramid_of(synthetic::warp(texture, kWidth, kHeight, Eigen::Vector2d::Zero()));
    const ImagePyramid second = pyramid_of(synthetic::warp(texture, kWidth, kHeight, shift, A, gain, offset));
    PatchAligner aligner;
    REQUIRE(ok(aligner.configure(15, kLevels, 20, 0.01)));
    PatchTemplate patch;
    aligner.allocate(patch);
    const Eigen::Vector2d c(0.5 * (kWidth - 1), 0.5 * (kHeight - 1));
    Errors errors;
    for (int v = 32; v < kHeight - 30; v += 11) {
        for (int u = 32; u < kWidth - 30; u += 11) {
            const Eigen::Vector2d at = Eigen::Vector2d(u, v) + sub_pixel;
            if (!ok(aligner.extract(first, at, {kLevels - 1, true}, patch))) {
                continue;  // too near the border for the coarsest level
            }
            const Eigen::Vector2d truth = A * (at - c) + c + shift;
            PatchPose pose{Eigen::Matrix2f::Identity(), truth + guess_error};
            float correlation = 0.0F;
            AlignOptions options;
            options.coarsest = kLevels - 1;
            options.affine = affine;
            ++errors.points;
            if (!ok(aligner.align(patch, second, options, pose, correlation))) {
                ++errors.failed;
                continue;
            }
            const double error = (pose.uv - truth).norm();
            errors.worst = std::max(errors.worst, error);
            errors.mean += error;
        }
    }
    errors.mean /= errors.points - errors.failed;
    return errors;
}

}  // namespace

TEST_CASE("alignment finds sub-pixel shifts", "[frontend]") {
    const bool affine = GENERATE(false, true);
    const Texture texture(11.0, 50.0, 7);
    for (const Eigen::Vector2d& shift :
         {Eigen::Vector2d(0.25, -0.5), Eigen::Vector2d(3.4, 2.7), Eigen::Vector2d(0.0, 0.0)}) {
        const Errors e =
            align_all(texture, shift, Eigen::Matrix2d::Identity(), 1.0, 0.0, affine, {2.0, -1.5}, {0.3, 0.6});
        CAPTURE(affine, shift.transpose(), e.worst, e.mean);
        CHECK(e.failed == 0);
        CHECK(e.mean < 0.035);
        CHECK(e.worst < 0.1);
    }
}

TEST_CASE("alignment does not see gain and offset", "[frontend]") {
    const Texture texture(11.0, 50.0, 8);
    const Errors up =
        align_all(texture, {1.3, -0.8}, Eigen::Matrix2d::Identity(), 1.3, -20.0, true, {1.5, 1.0}, {0.0, 0.0});
    CHECK(up.failed == 0);
    CHECK(up.worst < 0.1);
    const Errors down =
        align_all(texture, {1.3, -0.8}, Eigen::Matrix2d::Identity(), 0.6, 40.0, true, {1.5, 1.0}, {0.0, 0.0});
    CHECK(down.failed == 0);
    CHECK(down.worst < 0.1);
}

TEST_CASE("affine alignment follows rotation and scale, plain alignment less well", "[frontend]") {
    const Texture texture(11.0, 50.0, 9);
    Eigen::Matrix2d A;
    A << 1.12, -0.08, 0.1, 1.05;
    const Errors e = align_all(texture, {0.7, 0.4}, A, 1.0, 0.0, true, {1.0, 1.0}, {0.0, 0.0});
    const Errors plain = align_all(texture, {0.7, 0.4}, A, 1.0, 0.0, false, {1.0, 1.0}, {0.0, 0.0});
    CAPTURE(e.mean, e.worst, plain.mean);
    CHECK(e.failed == 0);
    CHECK(e.mean < 0.03);
    CHECK(e.worst < 0.1);
    CHECK(plain.mean > 2.0 * e.mean);
}

TEST_CASE("patches without texture or outside the image are refused", "[frontend]") {
    const ImagePyramid flat = pyramid_of(synthetic::Image(kWidth, kHeight, 90));
    synthetic::Image edge_image(kWidth, kHeight);
    for (int v = 0; v < kHeight; ++v) {
        for (int u = 0; u < kWidth; ++u) {
            edge_image.set(u, v, u < kWidth / 2 ? 40.0 : 200.0);
        }
    }
    const ImagePyramid edge = pyramid_of(edge_image);
    const ImagePyramid rich = pyramid_of(synthetic::warp(Texture(11.0, 50.0, 1), kWidth, kHeight, {0.0, 0.0}));
    PatchAligner aligner;
    REQUIRE(ok(aligner.configure(15, kLevels, 20, 0.01)));
    PatchTemplate patch;
    aligner.allocate(patch);
    CHECK(aligner.extract(flat, {80.0, 60.0}, {}, patch) == Status::kDegenerate);
    CHECK(aligner.extract(edge, {80.0, 60.0}, {}, patch) == Status::kDegenerate);
    CHECK(aligner.extract(rich, {4.0, 60.0}, {}, patch) == Status::kNotFound);
    REQUIRE(ok(aligner.extract(rich, {80.0, 60.0}, {}, patch)));

    PatchPose pose{Eigen::Matrix2f::Identity(), {80.0, 60.0}};
    float correlation = 0.0F;
    CHECK(aligner.align(patch, flat, {}, pose, correlation) == Status::kDegenerate);
    CHECK(pose.uv == Eigen::Vector2d(80.0, 60.0));
    pose.uv = {-500.0, 60.0};
    CHECK(aligner.align(patch, rich, {}, pose, correlation) == Status::kNotFound);
    pose.uv = {std::nan(""), 60.0};
    CHECK(!ok(aligner.align(patch, rich, {}, pose, correlation)));
    // Another part of the texture does not pass for this one.
    pose.uv = {110.0, 80.0};
    CHECK(aligner.align(patch, rich, {.coarsest = 0, .min_correlation = 0.9F}, pose, correlation) ==
          Status::kDegenerate);
    CHECK(aligner.configure(4, kLevels, 20, 0.01) == Status::kInvalidArgument);
}

TEST_CASE("correlation is one at the same place and low elsewhere", "[frontend]") {
    const ImagePyramid image = pyramid_of(synthetic::warp(Texture(11.0, 50.0, 1), kWidth, kHeight, {0.0, 0.0}));
    PatchAligner aligner;
    REQUIRE(ok(aligner.configure(15, kLevels, 20, 0.01)));
    PatchTemplate patch;
    aligner.allocate(patch);
    REQUIRE(ok(aligner.extract(image, {60.0, 60.0}, {}, patch)));
    CHECK(aligner.correlate(patch, image, 0, {Eigen::Matrix2f::Identity(), {60.0, 60.0}}) == Approx(1.0).margin(1e-4));
    CHECK(aligner.correlate(patch, image, 1, {Eigen::Matrix2f::Identity(), {60.0, 60.0}}) == Approx(1.0).margin(1e-4));
    CHECK(aligner.correlate(patch, image, 0, {Eigen::Matrix2f::Identity(), {85.0, 70.0}}) < 0.6F);
    CHECK(aligner.correlate(patch, image, 0, {Eigen::Matrix2f::Identity(), {2.0, 60.0}}) == -1.0F);
}

}  // namespace facet::patch_aligner_test
