// SPDX-License-Identifier: BSD-2-Clause
// What the example sees: a wall two metres ahead of a vehicle that rests for a second, then moves to and fro along it.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "estimator/geometry/se3.h"
#include "platform/base/samples.h"

class MadeUpWall {
public:
    static constexpr int kWidth = 640, kHeight = 480, kFocal_px = 400;  // of both cameras, which are 0.1 m apart

    /// Squares of 10 x 10 px in random grey.
    MadeUpWall() : picture_(kColumns * kHeight) {
        std::mt19937 random(1);
        for (int i = 0; i < kColumns * kHeight; ++i) {
            const int u = i % kColumns, v = i / kColumns;
            const bool begins = u % 10 == 0 && v % 10 == 0;
            picture_[i] = begins ? random() % 256 : v % 10 > 0 ? picture_[i - kColumns] : picture_[i - 1];
        }
    }
    Eigen::Vector3d position_W(double t) const { return {0.0, t < kRest_s ? 0.0 : kWay_m * (1.0 - cosine(t)), 0.0}; }
    double acceleration_m_per_s2(double t) const { return t < kRest_s ? 0.0 : kWay_m * kRate * kRate * cosine(t); }

    /// Images of the place at that time; valid until the next call.
    facet::StereoFrame frame(facet::Timestamp stamp) const {
        const double moved_px = position_W(stamp.seconds()).y() * kFocal_px / kDistance_m;
        for (const int side : {0, 1}) {
            images_[side].resize(kWidth * kHeight);
            for (int i = 0; i < kWidth * kHeight; ++i) {
                const double u = i % kWidth + kMargin + side * kDisparity - moved_px;
                const int whole = static_cast<int>(u);
                const std::uint8_t* left = &picture_[i / kWidth * kColumns + whole];
                images_[side][i] = static_cast<std::uint8_t>(left[0] + (u - whole) * (left[1] - left[0]) + 0.5);
            }
        }
        return {stamp, view(0), view(1)};
    }

private:
    static constexpr double kDistance_m = 2.0, kWay_m = 0.2, kRest_s = 1.0, kRate = 2.0;
    static constexpr int kDisparity = 20, kMargin = 100, kColumns = kWidth + kMargin + kDisparity + 1;

    static double cosine(double t) { return std::cos(kRate * (t - kRest_s)); }
    facet::ImageView view(int side) const { return {images_[side].data(), kWidth, kHeight, kWidth}; }

    std::vector<std::uint8_t> picture_;
    mutable std::array<std::vector<std::uint8_t>, 2> images_;
};
