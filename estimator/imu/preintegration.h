// SPDX-License-Identifier: BSD-2-Clause
// On-manifold preintegration of inertial samples between two keyframes, with covariance and bias Jacobians. [Forster17]
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "estimator/values/gravity.h"
#include "estimator/values/imu_noise.h"
#include "estimator/values/imu_scale.h"
#include "estimator/values/nav_state.h"
#include "platform/base/samples.h"
#include "platform/base/status.h"

namespace facet {

/// White noise of one step, separately for each axis of B: squared densities.
struct StepNoise {
    Eigen::Vector3d gyro = Eigen::Vector3d::Zero();   ///< ((rad/s)^2/Hz)
    Eigen::Vector3d accel = Eigen::Vector3d::Zero();  ///< ((m/s^2)^2/Hz)

    /// The sensor's own noise, equal on all axes.
    static StepNoise of(const ImuNoise& noise);
    StepNoise operator+(const StepNoise& o) const { return {gyro + o.gyro, accel + o.accel}; }
};

/// Relative motion from sums of samples between times i and j, independent of the state at i. [Forster17] eq.
/// (33)-(38):
///   dR = prod Exp((w - bg) dt),  dv = sum dR (a - ba) dt,  dp = sum dv dt + 1/2 dR (a - ba) dt^2
/// Integrated by the midpoint rule on consecutive samples: gyro and accel averaged over the step, (a - ba) rotated by
/// dR at its middle. The covariance, 9x9, order [theta p v], is that of the error Exp(d_theta) on the right of dR and
/// of dp and dv: from the noise given with each step and from add_edge_error(). The bias's random walk is not in it:
/// walk_covariance() is that. The deltas are free of gravity, which joins them when states are compared: its strength
/// is carried along, so that prediction, factor and start use one value. So is the scale of the IMU's axes, which turns
/// readings into rates and forces before the bias is subtracted. Thread-bound. No heap.
class Preintegration {
public:
    explicit Preintegration(const ImuBias& bias_linearised = {},
                            double gravity_m_per_s2 = GravityConfig{}.magnitude_m_per_s2)
        : bias_(bias_linearised), gravity_m_per_s2_(gravity_m_per_s2) {}

    /// The scale to integrate with, before the first step. @param differentiate  whether d_delta_d_scale() is needed
    void set_scale(const ImuScale& scale, bool differentiate) {
        scale_ = scale;
        differentiates_scale_ = differentiate;
    }

    /// Starts again with this bias and the same gravity and scale.
    void reset(const ImuBias& bias_linearised);

    /// Adds the step between two consecutive samples of one IMU.
    /// @return kOutOfOrder if b is not after a (nothing added).
    Status integrate(const ImuSample& a, const ImuSample& b, const ImuNoise& noise) {
        return integrate(a, b, StepNoise::of(noise));
    }
    Status integrate(const ImuSample& a, const ImuSample& b, const StepNoise& noise);

    /// Adds an error of the attitude that does not accumulate: it occurs at the present time only, about the axes of
    /// the present body frame. Before the first step it is an error at the beginning of the interval.
    /// @param theta_variance  (rad^2)
    void add_edge_error(const Eigen::Vector3d& theta_variance);

    double dt_s() const { return dt_s_; }
    const ImuBias& bias() const { return bias_; }
    const ImuScale& scale() const { return scale_; }
    bool differentiates_scale() const { return differentiates_scale_; }
    double gravity_m_per_s2() const { return gravity_m_per_s2_; }
    const Eigen::Quaterniond& delta_q() const { return dq_; }
    const Eigen::Vector3d& delta_p() const { return dp_; }
    const Eigen::Vector3d& delta_v() const { return dv_; }
    const Eigen::Matrix<double, 9, 9>& covariance() const { return covariance_; }
    /// What the biases' random walk within the interval adds to the covariance of the deltas, 15x15, order [theta p v
    /// bg ba]; the last six rows are the biases' own at j less those at i. A step of the walk at time s acts on a delta
    /// like (T - s)^n / n!, n counting the integrals between (1 for theta, 2 for v and 3 for p from the gyroscope, 1
    /// and 2 for v and p from the accelerometer, 0 for the biases), and a bias of the whole interval like T^n / n!,
    /// which d_delta_d_bias() has: covariances are the walk's variance at T times products of its columns, over
    /// n + m + 1. Exact where attitude and force are steady. In 0.2 s a thirtieth of the white noise, in
    /// seconds more than that.
    Eigen::Matrix<double, kStateDim, kStateDim> walk_covariance(const ImuNoise& noise) const;
    /// d[theta p v] / d[bg ba], 9x6, theta on the right of dR.
    const Eigen::Matrix<double, 9, 6>& d_delta_d_bias() const { return d_delta_d_bias_; }
    /// d[theta p v] / d(scale); zero unless it is needed.
    const Eigen::Matrix<double, 9, ImuScale::kDim>& d_delta_d_scale() const { return d_delta_d_scale_; }

    /// Deltas corrected to first order for a bias other than the linearised one. [Forster17] eq. (44)
    /// @param scale  other than the one integrated with, if its Jacobian is known; nullptr: that one
    void corrected(const ImuBias& bias, Eigen::Quaterniond& dq, Eigen::Vector3d& dp, Eigen::Vector3d& dv,
                   const ImuScale* scale = nullptr) const;

    /// State at j from the state at i (its bias is used and carried over).
    NavState predict(const NavState& state_i) const;

private:
    ImuBias bias_;
    double gravity_m_per_s2_;
    ImuScale scale_;
    bool differentiates_scale_ = false;
    double dt_s_ = 0.0;
    Eigen::Quaterniond dq_ = Eigen::Quaterniond::Identity();
    Eigen::Vector3d dp_ = Eigen::Vector3d::Zero();
    Eigen::Vector3d dv_ = Eigen::Vector3d::Zero();
    Eigen::Matrix<double, 9, 9> covariance_ = Eigen::Matrix<double, 9, 9>::Zero();
    Eigen::Matrix<double, 9, 6> d_delta_d_bias_ = Eigen::Matrix<double, 9, 6>::Zero();
    Eigen::Matrix<double, 9, ImuScale::kDim> d_delta_d_scale_ = Eigen::Matrix<double, 9, ImuScale::kDim>::Zero();
};

}  // namespace facet
