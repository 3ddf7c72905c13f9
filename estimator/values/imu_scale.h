// SPDX-License-Identifier: BSD-2-Clause
// Scale and misalignment of the IMU's axes.
#pragma once

#include <Eigen/Core>

namespace facet {

/// What readings w and a of gyroscope and accelerometer stand for, with the biases bg and ba:
///   w_B = (I + gyro) w - bg,   a_B = (I + accel) a - ba.
/// `accel` is lower triangular: the body's x axis is the accelerometer's, and its y axis lies in the plane of the
/// accelerometer's x and y. `gyro` is full, as it contains the gyroscope's rotation against the accelerometer.
/// The model of [Rehder16] and [Yang20], inverted; the bias is counted after the scale.
struct ImuScale {
    static constexpr int kGyroDim = 9;
    static constexpr int kDim = kGyroDim + 6;
    /// Order: `gyro` row by row, then the lower triangle of `accel` row by row.
    using Tangent = Eigen::Matrix<double, kDim, 1>;

    Eigen::Matrix3d gyro = Eigen::Matrix3d::Zero();   ///< (-)
    Eigen::Matrix3d accel = Eigen::Matrix3d::Zero();  ///< (-)

    ImuScale box_plus(const Tangent& d) const {
        ImuScale out = *this;
        int i = 0;
        for_each(out, [&](double& value) { value += d(i++); });
        return out;
    }
    /// The d with other = box_plus(d).
    Tangent box_minus_to(const ImuScale& other) const {
        ImuScale difference{other.gyro - gyro, other.accel - accel};
        Tangent d;
        int i = 0;
        for_each(difference, [&](double& value) { d(i++) = value; });
        return d;
    }
    /// Whether a parameter is a scale, on a diagonal, and not a misalignment.
    static constexpr bool is_diagonal(int parameter) {
        const int accel = parameter - kGyroDim;
        return parameter < kGyroDim ? parameter % 4 == 0 : (accel == 0 || accel == 2 || accel == 5);
    }

    /// Calls visit(value) for every parameter in the tangent's order.
    template <class Visit>
    static void for_each(ImuScale& scale, Visit visit) {
        for (int row = 0; row < 3; ++row) {
            for (int column = 0; column < 3; ++column) {
                visit(scale.gyro(row, column));
            }
        }
        for (int row = 0; row < 3; ++row) {
            for (int column = 0; column <= row; ++column) {
                visit(scale.accel(row, column));
            }
        }
    }
};

}  // namespace facet
