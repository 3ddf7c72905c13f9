// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/detector.h"

#include <catch2/catch.hpp>

#include "tests/estimator/frontend/synthetic.h"

namespace facet::detector_test {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 240;
constexpr double kBorder = 12.0;

FrontendConfig small_config() {
    FrontendConfig config;
    config.corners.min_distance_px = 12.0;
    config.corners.columns = 8;
    config.corners.rows = 6;
    return config;
}

/// A lens whose circle has a radius of 0.5 pi * focal: many images or less than one.
CameraModel lens(Distortion distortion, double focal_px) {
    return CameraModel({kWidth, kHeight, focal_px, focal_px, 159.5, 119.5, distortion, {}});
}

Detector make_detector(const FrontendConfig& config, const CameraModel& camera = lens(Distortion::kNone, 300.0)) {
    Detector detector;
    detector.configure(config, camera, kBorder);
    return detector;
}

PixelMask unmasked() {
    PixelMask mask;
    mask.configure(kWidth, kHeight);
    return mask;
}

}  // namespace

TEST_CASE("corners are spread evenly and keep their distance", "[frontend]") {
    // The contrast falls to a tenth from left to right: without cells, the left would take everything.
    const synthetic::Texture texture(11.0, 50.0, 3);
    synthetic::Image image(kWidth, kHeight);
    for (int v = 0; v < kHeight; ++v) {
        for (int u = 0; u < kWidth; ++u) {
            image.set(u, v, 128.0 + (texture.at(u, v) - 128.0) * (1.0 - 0.9 * u / kWidth));
        }
    }
    const FrontendConfig config = small_config();
    Detector detector = make_detector(config);
    CornerList corners;
    detector.detect(image.view(), {}, 96, corners);
    REQUIRE(corners.size() == 96);
    int cells[48] = {};
    for (std::size_t i = 0; i < corners.size(); ++i) {
        CHECK(corners[i].x() >= kBorder);
        CHECK(corners[i].y() >= kBorder);
        CHECK(corners[i].x() <= kWidth - 1 - kBorder);
        CHECK(corners[i].y() <= kHeight - 1 - kBorder);
        ++cells[static_cast<int>(corners[i].y()) * 6 / kHeight * 8 + static_cast<int>(corners[i].x()) * 8 / kWidth];
        for (std::size_t j = 0; j < i; ++j) {
            CHECK((corners[i] - corners[j]).norm() >= config.corners.min_distance_px);
        }
    }
    CHECK(std::count(std::begin(cells), std::end(cells), 0) == 0);
    CHECK(*std::max_element(std::begin(cells), std::end(cells)) <= 4);
}

TEST_CASE("corners keep away from tracks and fill empty cells first", "[frontend]") {
    const synthetic::Image image = synthetic::warp(synthetic::Texture(11.0, 50.0, 4), kWidth, kHeight, {0.0, 0.0});
    const FrontendConfig config = small_config();
    Detector detector = make_detector(config);
    CornerList tracks;
    detector.detect(image.view(), {}, 200, tracks);
    CornerList left_half;
    std::copy_if(tracks.begin(), tracks.end(), std::back_inserter(left_half),
                 [](const auto& c) { return c.x() < 160.0; });
    CornerList added;
    detector.detect(image.view(), {left_half.data(), left_half.size()}, 24, added);
    REQUIRE(added.size() == 24);
    for (const Eigen::Vector2d& corner : added) {
        CHECK(corner.x() > 150.0);
        for (const Eigen::Vector2d& track : left_half) {
            CHECK((corner - track).norm() > config.corners.min_distance_px - 1.0);
        }
    }
}

TEST_CASE("corners keep their distance to the border of the lens's circle", "[frontend]") {
    const synthetic::Image image = synthetic::warp(synthetic::Texture(11.0, 50.0, 4), kWidth, kHeight, {0.0, 0.0});
    const double focal_px = 100.0;
    Detector detector = make_detector(small_config(), lens(Distortion::kEquidistant, focal_px));
    CornerList corners;
    detector.detect(image.view(), {}, 300, corners);
    REQUIRE(corners.size() > 100);
    double farthest = 0.0;
    for (const Eigen::Vector2d& corner : corners) {
        farthest = std::max(farthest, (corner - Eigen::Vector2d(159.5, 119.5)).norm());
    }
    const double circle = focal_px * std::atan(10.0);
    CHECK(farthest < circle - kBorder);
    CHECK(farthest > circle - kBorder - 10.0);
}

TEST_CASE("corners stand on corners", "[frontend]") {
    synthetic::Image image(kWidth, kHeight, 60);
    for (int v = 100; v < 140; ++v) {
        for (int u = 150; u < 200; ++u) {
            image.set(u, v, 180.0);
        }
    }
    FrontendConfig config = small_config();
    config.corners.quality = 0.1;
    Detector detector = make_detector(config);
    CornerList corners;
    detector.detect(image.view(), {}, 50, corners);
    REQUIRE(corners.size() == 4);
    for (const Eigen::Vector2d& truth : {Eigen::Vector2d(149.5, 99.5), Eigen::Vector2d(199.5, 99.5),
                                         Eigen::Vector2d(149.5, 139.5), Eigen::Vector2d(199.5, 139.5)}) {
        const bool found =
            std::any_of(corners.begin(), corners.end(), [&](const auto& c) { return (c - truth).norm() < 3.0; });
        CHECK(found);
    }
}

TEST_CASE("images without corners give none, and a request for none is met", "[frontend]") {
    Detector detector = make_detector(small_config());
    CornerList corners;
    detector.detect(synthetic::Image(kWidth, kHeight, 0).view(), {}, 100, corners);
    detector.detect(synthetic::Image(kWidth, kHeight, 255).view(), {}, 100, corners);
    CHECK(corners.empty());
    const synthetic::Image image = synthetic::warp(synthetic::Texture(11.0, 50.0, 4), kWidth, kHeight, {0.0, 0.0});
    detector.detect(image.view(), {}, 0, corners);
    detector.detect(image.view(), {}, -5, corners);
    CHECK(corners.empty());
}

TEST_CASE("corners keep off a mask, drawn or found, and come back when that is forgotten", "[frontend]") {
    const synthetic::Texture texture(11.0, 50.0, 3);
    synthetic::Image image(kWidth, kHeight);
    synthetic::Image drawn(kWidth, kHeight, 255);
    for (int v = 0; v < kHeight; ++v) {
        for (int u = 0; u < kWidth; ++u) {
            image.set(u, v, texture.at(u, v));
            drawn.set(u, v, u < kWidth / 2 ? 0.0 : 255.0);
        }
    }
    PixelMask mask = unmasked();
    REQUIRE(ok(mask.draw(drawn.view())));
    Detector detector = make_detector(small_config());
    CornerList corners;
    detector.detect(image.view(), {}, 60, corners, &mask, {});
    REQUIRE(corners.size() > 20);
    const Timestamp now{1'000'000'000};
    for (const Eigen::Vector2d& corner : corners) {
        CHECK(corner.x() >= kWidth / 2);
        mask.cover(corner, now);
    }
    CornerList others;
    detector.detect(image.view(), {}, 60, others, &mask, now);
    for (const Eigen::Vector2d& corner : others) {
        const bool is_old = std::find(corners.begin(), corners.end(), corner) != corners.end();
        CHECK_FALSE(is_old);
    }
    CornerList later;
    detector.detect(image.view(), {}, 60, later, &mask, now + Duration::from_seconds(PixelMask::kMemory_s));
    CHECK(later == corners);
}

}  // namespace facet::detector_test
