// SPDX-License-Identifier: BSD-2-Clause
// What lens models that are symmetric about their axis have in common.
#pragma once

#include <Eigen/Core>
#include <array>

namespace facet {

/// The factor s that bends a normalised point, (x', y') = s(r^2) (x, y), with its derivatives by r^2 and by the model's
/// first two coefficients.
struct RadialScale {
    double value = 1.0;
    double d_r2 = 0.0;
    std::array<double, 2> d_k{};

    Eigen::Vector2d bend(const Eigen::Vector2d& xy, Eigen::Matrix2d* d_out_d_xy) const {
        if (d_out_d_xy != nullptr) {
            *d_out_d_xy = value * Eigen::Matrix2d::Identity() + 2.0 * d_r2 * xy * xy.transpose();
        }
        return value * xy;
    }
    /// Derivative of the bent radius r s by the angle atan(r).
    double slope_by_angle(double r2) const { return (value + 2.0 * r2 * d_r2) * (1.0 + r2); }
};

}  // namespace facet
