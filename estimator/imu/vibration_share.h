// SPDX-License-Identifier: BSD-2-Clause
// How much of the noise that vibration shows in the samples accumulates in their integrals.
#pragma once

#include <Eigen/Core>

namespace facet {

/// Density of an inertial sensor's noise near zero frequency over that in the bands of the VibrationMeter.
struct VibrationShare {
    double gyro = 1.0;
    double accel = 1.0;
};

/// An inertial factor's residual after an optimization, beside what the optimization leaves of it if the factor's noise
/// is as stated: both whitened, order [theta p v], p and v given theta.
struct InertialInnovation {
    double dt_s = 0.0;
    Eigen::Matrix<double, 9, 1> r;  ///< residual
    /// Covariance of r: I - A C A^T, with the Jacobian A of the residual and the covariance C of the states that it
    /// depends on. Its trace is the factor's redundancy.
    Eigen::Matrix<double, 9, 9> covariance;
};

/// Learns the share of the vibration that accumulates. A sum of samples over T is wrong by what the spectrum has within
/// 1/T of zero, where motion hides it from a meter; images, however, show motion, so that the share follows from what
/// they leave of the inertial factors.
///
/// With the noise's variance times exp(x), the restricted likelihood [Patterson71] of the rows r of the gyroscope (the
/// first three) or of the accelerometer (the others) has at x = 0, M being their covariance,
///   score  1/2 (r^T r - tr(M)),     information  1/2 tr(M^2),
/// so that factors of which the images say little count for little. Each moves the share's logarithm by its score over
/// the information gathered so far, which fades with a time constant of 10 s and is never below that of the prior: a
/// share of a tenth, since rotors have little near zero, and a factor of seven either way. r^T r counts up to four
/// times what is expected of it: a blunder is no noise. Thread-bound. No heap.
class VibrationLearner {
public:
    /// Goes back to the prior.
    void reset() { *this = {}; }
    /// Of a factor whose noise was raised for vibration by the present share.
    void learn_gyro(const InertialInnovation& innovation);
    void learn_accel(const InertialInnovation& innovation);

    VibrationShare share() const;

private:
    struct Logarithm {
        double x = -2.3;           ///< of the share
        double information = 0.0;  ///< beyond the prior's

        template <int kRows>
        void learn(const Eigen::Matrix<double, kRows, 1>& r, const Eigen::Matrix<double, kRows, kRows>& m,
                   const InertialInnovation& of);
    };

    Logarithm gyro_;
    Logarithm accel_;
};

}  // namespace facet
