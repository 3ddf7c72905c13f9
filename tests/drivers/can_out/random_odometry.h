// SPDX-License-Identifier: BSD-2-Clause
// Estimates of a vehicle that does everything at once.
#pragma once

#include <random>

#include "platform/port/odometry_sink.h"

namespace facet::test {

/// Positions to 100 m, speeds to 20 m/s, rates to 10 rad/s, any attitude, sigmas from 0.2 mm to a metre.
inline Odometry random_odometry(std::mt19937& random) {
    // Not std's distributions, which differ between libraries.
    const auto uniform = [&](double low, double high) {
        return low + (high - low) * static_cast<double>(random()) / static_cast<double>(std::mt19937::max());
    };
    const auto vector = [&](double limit) {
        return Eigen::Vector3d(uniform(-limit, limit), uniform(-limit, limit), uniform(-limit, limit));
    };
    Odometry odometry;
    odometry.stamp = {static_cast<std::int64_t>(uniform(1e9, 1e14))};
    odometry.p_W_B = vector(100.0);
    odometry.q_W_B = Eigen::Quaterniond(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)).normalized();
    odometry.v_W_B = vector(20.0);
    odometry.w_B = vector(10.0);
    for (int i = 0; i < 6; ++i) {
        odometry.pose_covariance(i, i) = uniform(4e-8, 1.0);
    }
    for (int i = 0; i < 3; ++i) {
        odometry.v_covariance(i, i) = uniform(4e-8, 1.0);
    }
    odometry.quality = static_cast<int>(uniform(-1.0, 100.0));
    odometry.reset_counter = static_cast<std::uint8_t>(random());
    odometry.state = static_cast<SinkState>(random() % 4);
    odometry.reasons = static_cast<std::uint32_t>(random());
    return odometry;
}

}  // namespace facet::test
