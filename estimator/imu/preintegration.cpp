// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/imu/preintegration.h"

#include <array>

namespace facet {
namespace {

using Matrix3 = Eigen::Matrix3d;

// Columns of the bias Jacobian.
constexpr int kGyro = 0;
constexpr int kAccel = 3;

/// One step of length h with the mean rate w and the mean specific force f of its two samples, bias subtracted:
///   Rm = dR Exp(w h / 2)
///   dR+ = dR Exp(w h),  dv+ = dv + Rm f h,  dp+ = dp + dv h + 1/2 Rm f h^2
/// and its exact first-order error model, x = [theta p v] with theta on the right of dR, n added to (w, f):
///   theta+ = Exp(w h)^T theta + h Jr(w h) n_w
///   v+     = v + h (D theta + G n_w + Rm n_f)
///   p+     = p + h v + h^2 / 2 (D theta + G n_w + Rm n_f)
/// A bias enters as n = -b.
struct Step {
    double h;
    Eigen::Quaterniond turn;  ///< Exp(w h)
    Eigen::Vector3d force;    ///< Rm f
    Matrix3 mid;              ///< Rm
    Matrix3 turn_back;        ///< Exp(w h)^T
    Matrix3 d_theta_d_w;      ///< Jr(w h)
    Matrix3 d_force_d_theta;  ///< D
    Matrix3 d_force_d_w;      ///< G

    Step(const Eigen::Quaterniond& dq, const Eigen::Vector3d& w, const Eigen::Vector3d& f, double h_s) : h(h_s) {
        const Eigen::Vector3d half_turn = 0.5 * h * w;
        const Eigen::Quaterniond q_half = so3_exp(half_turn);
        const Matrix3 half = q_half.toRotationMatrix();
        turn = so3_exp(2.0 * half_turn);
        mid = (dq * q_half).toRotationMatrix();
        force = mid * f;
        turn_back = turn.toRotationMatrix().transpose();
        d_theta_d_w = so3_right_jacobian(2.0 * half_turn);
        const Matrix3 d_force_d_theta_mid = -mid * skew(f);
        d_force_d_theta = d_force_d_theta_mid * half.transpose();
        d_force_d_w = d_force_d_theta_mid * so3_right_jacobian(half_turn) * (0.5 * h);
    }

    /// x = A x for every column of a 9 x N matrix, A the error model without noise, block by block.
    template <class Derived>
    void propagate(Eigen::MatrixBase<Derived>& x) const {
        using Rows = Eigen::Matrix<double, 3, Derived::ColsAtCompileTime>;
        const Rows theta = x.template middleRows<3>(kTheta);
        const Rows d_force = d_force_d_theta.lazyProduct(theta);
        x.template middleRows<3>(kPos) += h * x.template middleRows<3>(kVel) + (0.5 * h * h) * d_force;
        x.template middleRows<3>(kVel) += h * d_force;
        x.template middleRows<3>(kTheta) = turn_back.lazyProduct(theta);
    }
};

/// Adds the noise of one step, discrete variances sigma^2 / h. Using only the mean noise of the step would leave dp and
/// dv fully correlated (position variance sigma^2 h^3 / 4); white noise in continuous time has sigma^2 h^3 / 3, which
/// keeps the covariance positive definite from the first step on.
void add_noise(const Step& step, const StepNoise& noise, Eigen::Matrix<double, 9, 9>& covariance) {
    const double h = step.h;
    const Eigen::Vector3d gyro = noise.gyro / h;
    const Matrix3 theta = h * step.d_theta_d_w;
    const Matrix3 vel = h * step.d_force_d_w;
    const Matrix3 theta_vel = theta * gyro.asDiagonal() * vel.transpose();
    const Matrix3 vel_vel = vel * gyro.asDiagonal() * vel.transpose();
    const Matrix3 accel_vel = step.mid * (h * noise.accel).asDiagonal() * step.mid.transpose();
    covariance.block<3, 3>(kTheta, kTheta) += theta * gyro.asDiagonal() * theta.transpose();
    covariance.block<3, 3>(kTheta, kPos) += 0.5 * h * theta_vel;
    covariance.block<3, 3>(kTheta, kVel) += theta_vel;
    covariance.block<3, 3>(kPos, kTheta) += 0.5 * h * theta_vel.transpose();
    covariance.block<3, 3>(kPos, kPos) += 0.25 * h * h * vel_vel + h * h / 3.0 * accel_vel;
    covariance.block<3, 3>(kPos, kVel) += 0.5 * h * (vel_vel + accel_vel);
    covariance.block<3, 3>(kVel, kTheta) += theta_vel.transpose();
    covariance.block<3, 3>(kVel, kPos) += 0.5 * h * (vel_vel + accel_vel);
    covariance.block<3, 3>(kVel, kVel) += vel_vel + accel_vel;
}

/// Adds what one step makes of a change of the scale, which adds (dG w, dA f) to the mean readings w and f.
void add_scale(const Step& step, const Eigen::Vector3d& w, const Eigen::Vector3d& f,
               Eigen::Matrix<double, 9, ImuScale::kDim>& jacobian) {
    const double h = step.h;
    int column = 0;
    for (int row = 0; row < 3; ++row) {
        for (int i = 0; i < 3; ++i, ++column) {
            jacobian.col(column).segment<3>(kTheta) += h * w(i) * step.d_theta_d_w.col(row);
            jacobian.col(column).segment<3>(kPos) += 0.5 * h * h * w(i) * step.d_force_d_w.col(row);
            jacobian.col(column).segment<3>(kVel) += h * w(i) * step.d_force_d_w.col(row);
        }
    }
    for (int row = 0; row < 3; ++row) {
        for (int i = 0; i <= row; ++i, ++column) {
            jacobian.col(column).segment<3>(kPos) += 0.5 * h * h * f(i) * step.mid.col(row);
            jacobian.col(column).segment<3>(kVel) += h * f(i) * step.mid.col(row);
        }
    }
}

}  // namespace

StepNoise StepNoise::of(const ImuNoise& noise) {
    const auto squared = [](double density) { return Eigen::Vector3d::Constant(density * density).eval(); };
    return {squared(noise.gyro_noise_rad_per_s_per_sqrt_hz), squared(noise.accel_noise_m_per_s2_per_sqrt_hz)};
}

void Preintegration::reset(const ImuBias& bias_linearised) {
    Preintegration anew(bias_linearised, gravity_m_per_s2_);
    anew.set_scale(scale_, differentiates_scale_);
    *this = anew;
}

Status Preintegration::integrate(const ImuSample& a, const ImuSample& b, const StepNoise& noise) {
    if (!(b.stamp > a.stamp)) {
        return Status::kOutOfOrder;
    }
    const double h = (b.stamp - a.stamp).seconds();
    const Eigen::Vector3d w = 0.5 * (a.w_B + b.w_B);
    const Eigen::Vector3d f = 0.5 * (a.a_B + b.a_B);
    const Step step(dq_, w + scale_.gyro * w - bias_.gyro, f + scale_.accel * f - bias_.accel, h);

    // A C A^T = A (A C)^T for a symmetric C
    step.propagate(covariance_);
    covariance_.transposeInPlace();
    step.propagate(covariance_);
    add_noise(step, noise, covariance_);
    covariance_ = (0.5 * (covariance_ + covariance_.transpose())).eval();

    step.propagate(d_delta_d_bias_);
    d_delta_d_bias_.block<3, 3>(kTheta, kGyro) -= h * step.d_theta_d_w;
    d_delta_d_bias_.block<3, 3>(kPos, kGyro) -= 0.5 * h * h * step.d_force_d_w;
    d_delta_d_bias_.block<3, 3>(kVel, kGyro) -= h * step.d_force_d_w;
    d_delta_d_bias_.block<3, 3>(kPos, kAccel) -= 0.5 * h * h * step.mid;
    d_delta_d_bias_.block<3, 3>(kVel, kAccel) -= h * step.mid;
    if (differentiates_scale_) {
        step.propagate(d_delta_d_scale_);
        add_scale(step, w, f, d_delta_d_scale_);
    }

    dp_ += h * dv_ + 0.5 * h * h * step.force;
    dv_ += h * step.force;
    dq_ = (dq_ * step.turn).normalized();
    dt_s_ += h;
    return Status::kOk;
}

void Preintegration::add_edge_error(const Eigen::Vector3d& theta_variance) {
    covariance_.diagonal().segment<3>(kTheta) += theta_variance;
}

Eigen::Matrix<double, kStateDim, kStateDim> Preintegration::walk_covariance(const ImuNoise& noise) const {
    using Orders = std::array<int, 5>;  // integrals between the walk and theta, p, v, bg and ba
    constexpr Orders kFromGyro{1, 3, 2, 0, 0};
    constexpr Orders kFromAccel{0, 2, 1, 0, 0};
    Eigen::Matrix<double, kStateDim, kStateDim> covariance = Eigen::Matrix<double, kStateDim, kStateDim>::Zero();
    const auto add = [&](int column, int bias, const Orders& orders, double density) {
        Eigen::Matrix<double, kStateDim, 3> d = Eigen::Matrix<double, kStateDim, 3>::Zero();
        d.topRows<9>() = d_delta_d_bias_.middleCols<3>(column);
        d.middleRows<3>(bias).setIdentity();
        for (int a = 0; a < 5; ++a) {
            for (int b = 0; b < 5; ++b) {
                const double share = density * density * dt_s_ / (orders[a] + orders[b] + 1);
                covariance.block<3, 3>(3 * a, 3 * b) +=
                    share * d.middleRows<3>(3 * a).lazyProduct(d.middleRows<3>(3 * b).transpose());
            }
        }
    };
    add(kGyro, kBiasGyro, kFromGyro, noise.gyro_walk_rad_per_s2_per_sqrt_hz);
    add(kAccel, kBiasAccel, kFromAccel, noise.accel_walk_m_per_s3_per_sqrt_hz);
    return covariance;
}

void Preintegration::corrected(const ImuBias& bias, Eigen::Quaterniond& dq, Eigen::Vector3d& dp, Eigen::Vector3d& dv,
                               const ImuScale* scale) const {
    Eigen::Matrix<double, 6, 1> d_bias;
    d_bias << bias.gyro - bias_.gyro, bias.accel - bias_.accel;
    Eigen::Matrix<double, 9, 1> d = d_delta_d_bias_.lazyProduct(d_bias);
    if (scale != nullptr && differentiates_scale_) {
        d += d_delta_d_scale_.lazyProduct(scale_.box_minus_to(*scale));
    }
    dq = (dq_ * so3_exp(d.segment<3>(kTheta))).normalized();
    dp = dp_ + d.segment<3>(kPos);
    dv = dv_ + d.segment<3>(kVel);
}

NavState Preintegration::predict(const NavState& state_i) const {
    Eigen::Quaterniond dq;
    Eigen::Vector3d dp;
    Eigen::Vector3d dv;
    corrected(state_i.bias, dq, dp, dv);
    const Eigen::Vector3d g_W = gravity_W(gravity_m_per_s2_);
    NavState state_j = state_i;
    state_j.q_W_B = (state_i.q_W_B * dq).normalized();
    state_j.p_W_B += dt_s_ * state_i.v_W_B + 0.5 * dt_s_ * dt_s_ * g_W + state_i.q_W_B * dp;
    state_j.v_W_B += dt_s_ * g_W + state_i.q_W_B * dv;
    return state_j;
}

}  // namespace facet
