// SPDX-License-Identifier: BSD-2-Clause
// A vehicle at rest, or gliding along, before a textured wall: images and inertial samples for the whole estimator.
#pragma once

#include <catch2/catch.hpp>
#include <cstdint>
#include <random>
#include <vector>

#include "estimator/api/estimator.h"
#include "tests/support/synthetic_flight.h"

namespace facet::test {

/// A still vehicle 3.1 m in front of a wall with a random texture: the right picture is the left one moved by 16 px.
class StillVehicle {
public:
    explicit StillVehicle(double imu_rate_hz = 200.0)
        : imu_step_s_(1.0 / imu_rate_hz), picture_(kStride * 480U), dark_(752U * 480U, 0) {
        std::mt19937 generator(3);
        // Blocks of 8 px of random grey: corners everywhere.
        std::vector<std::uint8_t> blocks(94U * 60U);
        for (auto& b : blocks) {
            b = static_cast<std::uint8_t>(generator() % 200U + 20U);
        }
        for (std::size_t v = 0; v < 480; ++v) {
            for (std::size_t u = 0; u < kStride; ++u) {  // twice the wall, and what the right camera sees beyond
                picture_[v * kStride + u] = blocks[(v / 8) * 94 + (u % 752) / 8];
            }
        }
        rig = make_rig();
        rig.T_B_C1.q = rig.T_B_C0.q;
        rig.T_B_C1.p.z() = rig.T_B_C0.p.z();
    }
    /// @param push_x  acceleration that the sensor shows and the vehicle does not have
    void feed_imu(Estimator& estimator, double t0, double t1, double push_x = 0.0) const {
        for (double t = t0; t < t1 - 1e-9; t += imu_step_s_) {
            REQUIRE(ok(estimator.add_imu({at(t), {0.001, -0.002, 0.003}, {push_x, 0.0, 9.81}})));
        }
    }
    StereoFrame frame(double t, bool dark = false) const {
        if (dark) {
            const ImageView black{dark_.data(), 752, 480, 752};
            return {at(t), black, black};
        }
        return moved_frame(t, 0);
    }
    /// After a way to the cameras' right along the wall. @param shift_px  by which the picture has moved, >= 0
    StereoFrame moved_frame(double t, int shift_px) const {
        const std::uint8_t* begin = picture_.data() + shift_px % 752;
        return {at(t), {begin, 752, 480, kStride}, {begin + kDisparity_px, 752, 480, kStride}};
    }
    /// The way that moves the picture by a pixel, in the body frame.
    Eigen::Vector3d way_of_pixel_B() const {
        return rig.T_B_C0.q * Eigen::Vector3d(rig.baseline_m() / kDisparity_px, 0.0, 0.0);
    }
    StereoRig rig;

private:
    static constexpr int kDisparity_px = 16;
    static constexpr int kStride = 2 * 752 + kDisparity_px;
    double imu_step_s_;
    std::vector<std::uint8_t> picture_;
    std::vector<std::uint8_t> dark_;
};

}  // namespace facet::test
