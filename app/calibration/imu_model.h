// SPDX-License-Identifier: BSD-2-Clause
// How an IMU's readings differ from what they should be, biases aside.
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>

#include "platform/base/samples.h"

namespace facet {

/// Scale, misalignment and the gyroscope's sensitivity to acceleration, all constant: Kalibr's model [Rehder16], and
/// OpenVINS's in other letters. Of the true specific force a and angular rate w in the body frame the sensor reads
///   a_m = M_a a + bias,   w_m = M_w w + M_g a + bias
/// What is left of the biases, turned by the inverse matrices, the estimator finds. Reentrant. No heap.
///
/// [Rehder16] Extending kalibr: Calibrating the extrinsics of multiple IMUs and of individual axes, ICRA 2016.
class ImuModel {
public:
    ImuModel() = default;  ///< an ideal IMU
    /// The first two must be invertible.
    ImuModel(const Eigen::Matrix3d& M_a, const Eigen::Matrix3d& M_w, const Eigen::Matrix3d& M_g)
        : M_a_(M_a),
          M_w_(M_w),
          M_g_(M_g),
          inverse_M_a_(M_a.inverse()),
          inverse_M_w_(M_w.inverse()),
          feels_force_(!M_g.isZero(0.0)),
          is_ideal_(M_a.isIdentity(0.0) && M_w.isIdentity(0.0) && !feels_force_) {}

    bool is_ideal() const { return is_ideal_; }
    const Eigen::Matrix3d& M_a() const { return M_a_; }
    const Eigen::Matrix3d& M_w() const { return M_w_; }
    const Eigen::Matrix3d& M_g() const { return M_g_; }  ///< (rad/s)/(m/s^2)

    /// What an ideal IMU would have read. A reading that is NaN spoils only what is computed of it.
    ImuSample corrected(const ImuSample& measured) const {
        if (is_ideal_) {
            return measured;
        }
        ImuSample sample{measured.stamp, measured.w_B, inverse_M_a_ * measured.a_B};
        if (feels_force_) {
            sample.w_B -= M_g_ * sample.a_B;
        }
        sample.w_B = inverse_M_w_ * sample.w_B;
        return sample;
    }

private:
    Eigen::Matrix3d M_a_ = Eigen::Matrix3d::Identity();
    Eigen::Matrix3d M_w_ = Eigen::Matrix3d::Identity();
    Eigen::Matrix3d M_g_ = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d inverse_M_a_ = Eigen::Matrix3d::Identity();
    Eigen::Matrix3d inverse_M_w_ = Eigen::Matrix3d::Identity();
    bool feels_force_ = false;
    bool is_ideal_ = true;
};

}  // namespace facet
