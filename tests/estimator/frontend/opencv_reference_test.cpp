// SPDX-License-Identifier: BSD-2-Clause
// The front-end's own image operations against OpenCV's.
#include <catch2/catch.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "estimator/frontend/corner_score.h"
#include "estimator/frontend/image_pyramid.h"

namespace facet::opencv_reference_test {
namespace {

/// Smooth random texture with some hard edges.
cv::Mat texture(int width, int height, unsigned seed) {
    std::mt19937 generator(seed);
    std::uniform_int_distribution<int> grey(0, 255);
    cv::Mat image(height, width, CV_8U);
    for (int v = 0; v < height; ++v) {
        for (int u = 0; u < width; ++u) {
            image.at<std::uint8_t>(v, u) = static_cast<std::uint8_t>(grey(generator));
        }
    }
    cv::GaussianBlur(image, image, {5, 5}, 1.2);
    cv::rectangle(image, {width / 4, height / 4}, {width / 2, height / 2}, 250, -1);
    cv::rectangle(image, {width / 3, height / 3}, {3 * width / 4, 3 * height / 4}, 5, 2);
    return image;
}

ImageView view(const cv::Mat& image) {
    return {image.data, image.cols, image.rows, static_cast<std::ptrdiff_t>(image.step)};
}

}  // namespace

TEST_CASE("the pyramid is OpenCV's, pixel by pixel", "[image_pyramid]") {
    const auto [width, height] = GENERATE(std::pair{752, 480}, std::pair{161, 99}, std::pair{130, 67});
    const cv::Mat image = texture(width, height, 3);
    ImagePyramid pyramid;
    REQUIRE(ok(pyramid.configure(width, height, 3)));
    pyramid.build(view(image));
    cv::Mat reference = image;
    for (int level = 1; level < pyramid.levels(); ++level) {
        cv::Mat smaller;
        const ImageView& ours = pyramid.level(level);
        cv::pyrDown(reference, smaller, {ours.width, ours.height});
        const cv::Mat wrapped(ours.height, ours.width, CV_8U, const_cast<std::uint8_t*>(ours.data),
                              static_cast<std::size_t>(ours.stride));
        INFO("level " << level);
        CHECK(cv::norm(wrapped, smaller, cv::NORM_INF) == 0.0);
        reference = smaller;
    }
}

TEST_CASE("the corner score is OpenCV's least eigenvalue", "[corner_score]") {
    const cv::Mat image = texture(200, 120, 7);
    CornerScore score;
    score.configure(image.cols, image.rows);
    score.compute(view(image));
    cv::Mat reference;
    cv::cornerMinEigenVal(image, reference, 5, 3);
    double worst = 0.0;
    for (int v = CornerScore::kReach; v < image.rows - CornerScore::kReach; ++v) {
        for (int u = CornerScore::kReach; u < image.cols - CornerScore::kReach; ++u) {
            worst = std::max(worst, std::abs(double{score.row(v)[u]} - double{reference.at<float>(v, u)}));
        }
    }
    CHECK(worst < 1e-4 * double{score.best()});
    CHECK(double{score.best()} > 0.01);
}

}  // namespace facet::opencv_reference_test
