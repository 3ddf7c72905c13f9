// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/imu/dynamic_init.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

namespace facet {
namespace {

// Vision and IMU contradict each other if their squared residuals per degree of freedom exceed this.
constexpr double kMaxChi2PerDof = 3.0;
// Largest standard deviation of the direction of gravity with which it counts as observed (rad).
constexpr double kMaxTiltSigma_rad = 0.05;
constexpr int kFreeSteps = 3;
constexpr int kBoundSteps = 4;
constexpr double kGravitySigmas = 4.0;
constexpr double kGaugeSigma = 1e-4;     // position (m) and yaw (rad): a choice, not an estimate
constexpr double kMinTiltSigma = 1e-4;   // rad
constexpr double kMinVelSigma = 1e-4;    // m/s
constexpr double kMaxFreeGravity = 5.0;  // deviation of the free gravity (m/s^2)
constexpr double kMinFreeGravity = 1.0;  // m/s^2

// Unknowns: [bg ba g u_0 .. u_n], those of one motion [bg ba g u_k u_k+1].
constexpr int kBg = 0;
constexpr int kBa = 3;
constexpr int kG = 6;
constexpr int kU = 9;
constexpr int kLocal = 15;
constexpr int kMaxUnknowns = kU + 3 * kMaxInitKeyframes;

using Matrix3 = Eigen::Matrix3d;
using Matrix9 = Eigen::Matrix<double, 9, 9>;
using Matrix12 = Eigen::Matrix<double, 12, 12>;
using Jacobian = Eigen::Matrix<double, 9, kLocal>;
using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxUnknowns, 1>;
using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxUnknowns, kMaxUnknowns>;

struct Unknowns {
    ImuBias bias;
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
    std::array<Eigen::Vector3d, kMaxInitKeyframes> u{};
};

/// Chain of turns up to a keyframe.
struct Chain {
    Matrix3 R_0_k = Matrix3::Identity();
    Matrix3 d_theta_d_bg = Matrix3::Zero();  ///< of R_0_k, theta on the right
    Matrix3 covariance = Matrix3::Zero();    ///< of theta, white noise only

    void advance(const Preintegration& imu, const Eigen::Quaterniond& dq) {
        const Matrix3 R = dq.toRotationMatrix();
        R_0_k = (R_0_k * R).eval();
        d_theta_d_bg = (R.transpose() * d_theta_d_bg + imu.d_delta_d_bias().block<3, 3>(kTheta, 0)).eval();
        covariance = (R.transpose() * covariance * R + imu.covariance().block<3, 3>(kTheta, kTheta)).eval();
    }
};

/// Normal equations at a point.
struct System {
    Matrix h;
    Vector b;  ///< - J^T r
    double squared_error = 0.0;
    int rows = 0;
};

/// Whitened residual and Jacobian of one motion. Without visual rotation the first three rows are zero.
bool linearize(const KeyframeMotion& motion, const Unknowns& x, int k, const Chain& chain, Jacobian& j,
               Eigen::Matrix<double, 9, 1>& r) {
    const double dt = motion.imu.dt_s();
    Eigen::Quaterniond dq;
    Eigen::Vector3d dp;
    Eigen::Vector3d dv;
    motion.imu.corrected(x.bias, dq, dp, dv);
    const auto& d_bias = motion.imu.d_delta_d_bias();
    const Matrix3 R_k_0 = chain.R_0_k.transpose();
    const Eigen::Vector3d& u_k = x.u[static_cast<std::size_t>(k)];
    const Eigen::Vector3d& u_j = x.u[static_cast<std::size_t>(k + 1)];
    const Eigen::Vector3d path = R_k_0 * (dt * u_k + 0.5 * dt * dt * x.g);
    const Eigen::Vector3d gain = R_k_0 * (u_j - u_k - dt * x.g);

    r.setZero();
    j.setZero();
    r.segment<3>(kPos) = motion.p_Bk_Bj - path - dp;
    r.segment<3>(kVel) = gain - dv;
    j.block<3, 6>(kPos, kBg) = -d_bias.middleRows<3>(kPos);
    j.block<3, 3>(kPos, kBg) -= skew(path) * chain.d_theta_d_bg;
    j.block<3, 3>(kPos, kG) = -0.5 * dt * dt * R_k_0;
    j.block<3, 3>(kPos, kU) = -dt * R_k_0;
    j.block<3, 6>(kVel, kBg) = -d_bias.middleRows<3>(kVel);
    j.block<3, 3>(kVel, kBg) += skew(gain) * chain.d_theta_d_bg;
    j.block<3, 3>(kVel, kG) = -dt * R_k_0;
    j.block<3, 3>(kVel, kU) = -R_k_0;
    j.block<3, 3>(kVel, kU + 3) = R_k_0;

    Matrix9 covariance = motion.imu.covariance();
    covariance.diagonal().array() += 1e-12;
    covariance.block<3, 3>(kPos, kPos) += motion.p_covariance;
    Eigen::Matrix<double, 6, 3> d_r_d_chain;
    d_r_d_chain << -skew(path), skew(gain);
    covariance.bottomRightCorner<6, 6>() += d_r_d_chain * chain.covariance * d_r_d_chain.transpose();
    if (motion.has_rotation) {
        r.segment<3>(kTheta) = so3_log(dq.conjugate() * motion.q_Bk_Bj);
        j.block<3, 6>(kTheta, kBg) = -d_bias.middleRows<3>(kTheta);
        covariance.block<3, 3>(kTheta, kTheta) += motion.theta_covariance;
    } else {
        covariance.topRows<3>().setZero();
        covariance.leftCols<3>().setZero();
        covariance.topLeftCorner<3, 3>().setIdentity();
    }
    const Eigen::LLT<Matrix9> llt(covariance);
    if (!covariance.allFinite() || llt.info() != Eigen::Success) {
        return false;
    }
    llt.matrixL().solveInPlace(r);
    llt.matrixL().solveInPlace(j);
    return true;
}

/// Normal equations of all motions and the bias priors. gravity_basis: directions in which g may move, its columns.
bool build(std::span<const KeyframeMotion> motions, const DynamicInitConfig& config, const Unknowns& x,
           const Matrix3& gravity_basis, System& system) {
    const auto n = static_cast<int>(motions.size());
    system.h.setZero(kU + 3 * (n + 1), kU + 3 * (n + 1));
    system.b.setZero(kU + 3 * (n + 1));
    const Eigen::Vector3d d_gyro = x.bias.gyro - motions[0].imu.bias().gyro;
    const Eigen::Vector3d d_accel = x.bias.accel - motions[0].imu.bias().accel;
    const double w_gyro = 1.0 / (config.gyro_bias_sigma_rad_per_s * config.gyro_bias_sigma_rad_per_s);
    const double w_accel = 1.0 / (config.accel_bias_sigma_m_per_s2 * config.accel_bias_sigma_m_per_s2);
    system.h.diagonal().segment<3>(kBg).setConstant(w_gyro);
    system.h.diagonal().segment<3>(kBa).setConstant(w_accel);
    system.b.segment<3>(kBg) = -w_gyro * d_gyro;
    system.b.segment<3>(kBa) = -w_accel * d_accel;
    system.squared_error = w_gyro * d_gyro.squaredNorm() + w_accel * d_accel.squaredNorm();
    system.rows = 6;
    Chain chain;
    Jacobian j;
    Eigen::Matrix<double, 9, 1> r;
    for (int k = 0; k < n; ++k) {
        const KeyframeMotion& motion = motions[static_cast<std::size_t>(k)];
        if (!linearize(motion, x, k, chain, j, r)) {
            return false;
        }
        j.middleCols<3>(kG) = (j.middleCols<3>(kG) * gravity_basis).eval();
        const Eigen::Matrix<double, kLocal, kLocal> h = j.transpose() * j;
        const Eigen::Matrix<double, kLocal, 1> b = -j.transpose() * r;
        const int u = kU + 3 * k;
        system.h.topLeftCorner<kU, kU>() += h.topLeftCorner<kU, kU>();
        system.h.block<kU, 6>(0, u) += h.topRightCorner<kU, 6>();
        system.h.block<6, kU>(u, 0) += h.bottomLeftCorner<6, kU>();
        system.h.block<6, 6>(u, u) += h.bottomRightCorner<6, 6>();
        system.b.head<kU>() += b.head<kU>();
        system.b.segment<6>(u) += b.tail<6>();
        system.squared_error += r.squaredNorm();
        system.rows += motion.has_rotation ? 9 : 6;
        Eigen::Quaterniond dq;
        Eigen::Vector3d unused;
        motion.imu.corrected(x.bias, dq, unused, unused);
        chain.advance(motion.imu, dq);
    }
    for (int axis = 0; axis < 3; ++axis) {
        if (gravity_basis.col(axis).isZero()) {
            system.h(kG + axis, kG + axis) = 1.0;  // held
        }
    }
    return true;
}

/// Two directions normal to g; the third column is zero.
Matrix3 tangent_plane(const Eigen::Vector3d& g) {
    const Eigen::Vector3d up = g.normalized();
    Matrix3 basis = Matrix3::Zero();
    basis.col(0) = up.unitOrthogonal();
    basis.col(1) = up.cross(basis.col(0));
    return basis;
}

void move(Unknowns& x, const Vector& d, const Matrix3& gravity_basis, int keyframes) {
    x.bias.gyro += d.segment<3>(kBg);
    x.bias.accel += d.segment<3>(kBa);
    x.g += gravity_basis * d.segment<3>(kG);
    for (int k = 0; k < keyframes; ++k) {
        x.u[static_cast<std::size_t>(k)] += d.segment<3>(kU + 3 * k);
    }
}

/// Gauss-Newton; on success the system is the one at x.
bool solve(std::span<const KeyframeMotion> motions, const DynamicInitConfig& config, bool is_bound, Unknowns& x,
           System& system) {
    const auto keyframes = static_cast<int>(motions.size()) + 1;
    for (int step = 0; step < (is_bound ? kBoundSteps : kFreeSteps); ++step) {
        const Matrix3 basis = is_bound ? tangent_plane(x.g) : Matrix3(Matrix3::Identity());
        if (!build(motions, config, x, basis, system)) {
            return false;
        }
        const Eigen::LLT<Eigen::Ref<Matrix>> llt(system.h);
        if (llt.info() != Eigen::Success) {
            return false;
        }
        Vector d = system.b;
        llt.solveInPlace(d);
        if (!d.allFinite()) {
            return false;
        }
        move(x, d, basis, keyframes);
        if (is_bound) {
            x.g *= motions[0].imu.gravity_m_per_s2() / x.g.norm();
        }
    }
    return build(motions, config, x, is_bound ? tangent_plane(x.g) : Matrix3(Matrix3::Identity()), system);
}

/// Rates of straight motion: velocities from the positions, gravity from forces that only hold the body up.
Unknowns first_guess(std::span<const KeyframeMotion> motions) {
    Unknowns x;
    x.bias = motions[0].imu.bias();
    Chain chain;
    double total_s = 0.0;
    for (std::size_t k = 0; k < motions.size(); ++k) {
        const Preintegration& imu = motions[k].imu;
        x.u[k] = chain.R_0_k * motions[k].p_Bk_Bj / imu.dt_s();
        x.u[k + 1] = x.u[k];
        x.g -= chain.R_0_k * imu.delta_v();
        total_s += imu.dt_s();
        chain.advance(imu, imu.delta_q());
    }
    x.g /= total_s;
    return x;
}

/// The free gravity must be known and have the magnitude of the true one within its uncertainty.
Status judge_gravity(const Unknowns& x, const System& system, double true_norm) {
    Matrix h = system.h;
    const Eigen::LLT<Eigen::Ref<Matrix>> llt(h);
    if (llt.info() != Eigen::Success) {
        return Status::kDegenerate;
    }
    Eigen::Matrix<double, Eigen::Dynamic, 3, 0, kMaxUnknowns, 3> columns;
    columns.setZero(h.rows(), 3);
    columns.middleRows<3>(kG).setIdentity();
    llt.solveInPlace(columns);
    const Matrix3 covariance = columns.middleRows<3>(kG);
    if (!(covariance.diagonal().maxCoeff() < kMaxFreeGravity * kMaxFreeGravity)) {
        return Status::kDegenerate;
    }
    const double norm = x.g.norm();
    const double sigma = norm > 0.0 ? std::sqrt(x.g.dot(covariance * x.g)) / norm : 0.0;
    const bool fits = norm > kMinFreeGravity && std::abs(norm - true_norm) < kGravitySigmas * sigma;
    return fits ? Status::kOk : Status::kCorrupt;
}

/// Covariance of [theta v bg ba] at the last keyframe, theta without a part about the vertical (frames: see header).
///   up' = Exp(-turn)(up - R_0n^T dg / |g|),  up x theta = up' - up,  v' = R_W_B Exp(theta) Exp(-turn) R_0n^T (u + du)
/// where turn = d_theta_d_bg dbg + white noise.
bool last_covariance(const System& system, const Unknowns& x, const Chain& chain, const NavState& state,
                     Matrix12& covariance, double& body_velocity_sigma) {
    const auto size = static_cast<int>(system.h.rows());
    const Eigen::Vector3d up = -(chain.R_0_k.transpose() * x.g).normalized();
    const Matrix3 R_W_B = state.q_W_B.toRotationMatrix();
    const Eigen::Vector3d v_B = R_W_B.transpose() * state.v_W_B;
    Eigen::Matrix<double, 12, 3> d_turn = Eigen::Matrix<double, 12, 3>::Zero();
    d_turn.topRows<3>() = -skew(up) * skew(up);
    d_turn.middleRows<3>(3) = R_W_B * (skew(v_B) - skew(v_B) * d_turn.topRows<3>());
    Eigen::Matrix<double, Eigen::Dynamic, 12, 0, kMaxUnknowns, 12> m;  // transposed map
    m.setZero(size, 12);
    const Matrix3 d_theta_d_g = skew(up) * chain.R_0_k.transpose() * tangent_plane(x.g) / x.g.norm();
    m.block<3, 6>(kBg, 0) = (d_turn.topRows<6>() * chain.d_theta_d_bg).transpose();
    m.block<3, 3>(kBg, 6).setIdentity();
    m.block<3, 3>(kBa, 9).setIdentity();
    m.block<3, 3>(kG, 0) = d_theta_d_g.transpose();
    m.block<3, 3>(kG, 3) = (-R_W_B * skew(v_B) * d_theta_d_g).transpose();
    m.block<3, 3>(size - 3, 3) = (R_W_B * chain.R_0_k.transpose()).transpose();
    Matrix h = system.h;
    const Eigen::LLT<Eigen::Ref<Matrix>> llt(h);
    if (llt.info() != Eigen::Success) {
        return false;
    }
    Eigen::Matrix<double, Eigen::Dynamic, 3, 0, kMaxUnknowns, 3> u_n;
    u_n.setZero(size, 3);
    u_n.bottomRows<3>().setIdentity();
    llt.matrixL().solveInPlace(u_n);
    body_velocity_sigma = u_n.colwise().norm().maxCoeff();
    llt.matrixL().solveInPlace(m);
    covariance = m.transpose() * m;
    covariance += d_turn * chain.covariance * d_turn.transpose();
    covariance.topLeftCorner<3, 3>() += kGaugeSigma * kGaugeSigma * up * up.transpose();
    covariance.diagonal().head<3>().array() += kMinTiltSigma * kMinTiltSigma * 1e-2;
    covariance.diagonal().segment<3>(3).array() += kMinVelSigma * kMinVelSigma;
    return covariance.allFinite();
}

/// The root of the information, order [theta p v bg ba].
bool fill_information(const Matrix12& covariance, InitialState& initial) {
    const Eigen::LLT<Matrix12> llt(covariance);
    if (llt.info() != Eigen::Success) {
        return false;
    }
    Matrix12 root = Matrix12::Identity();  // L^-1: its square is the information
    llt.matrixL().solveInPlace(root);
    initial.sqrt_information.setZero();
    initial.sqrt_information.topLeftCorner<3, 3>() = root.topLeftCorner<3, 3>();
    initial.sqrt_information.bottomLeftCorner<9, 3>() = root.bottomLeftCorner<9, 3>();
    initial.sqrt_information.bottomRightCorner<9, 9>() = root.bottomRightCorner<9, 9>();
    initial.sqrt_information.diagonal().segment<3>(kPos).setConstant(1.0 / kGaugeSigma);
    const Matrix3 R_W_B = initial.state.q_W_B.toRotationMatrix();
    const Matrix3 theta_W = R_W_B * covariance.topLeftCorner<3, 3>() * R_W_B.transpose();
    initial.tilt_sigma_rad = std::sqrt(std::max(theta_W(0, 0), theta_W(1, 1)));
    return true;
}

}  // namespace

Status DynamicInitConfig::validate() const { return validate_fields(kDynamicInitFields, *this); }

Status initialize_in_motion(std::span<const KeyframeMotion> motions, const DynamicInitConfig& config,
                            DynamicInit& out) {
    const bool has_length =
        std::all_of(motions.begin(), motions.end(), [](const KeyframeMotion& m) { return m.imu.dt_s() > 0.0; });
    if (motions.size() < 2 || motions.size() >= kMaxInitKeyframes || !has_length) {
        return Status::kInvalidArgument;
    }
    Unknowns x = first_guess(motions);
    System system;
    if (!solve(motions, config, false, x, system)) {
        return Status::kDegenerate;
    }
    const double gravity = motions[0].imu.gravity_m_per_s2();
    FACET_TRY(judge_gravity(x, system, gravity));
    DynamicInit result;
    result.gravity_norm_m_per_s2 = x.g.norm();
    x.g *= gravity / x.g.norm();
    if (!solve(motions, config, true, x, system)) {
        return Status::kDegenerate;
    }
    Chain chain;
    for (const KeyframeMotion& motion : motions) {
        Eigen::Quaterniond dq;
        Eigen::Vector3d unused;
        motion.imu.corrected(x.bias, dq, unused, unused);
        chain.advance(motion.imu, dq);
    }
    const Eigen::Vector3d up = -(chain.R_0_k.transpose() * x.g).normalized();
    NavState& state = result.initial.state;
    state.q_W_B = level_attitude(up);
    state.v_W_B = state.q_W_B * (chain.R_0_k.transpose() * x.u[motions.size()]);
    state.bias = x.bias;
    Matrix12 covariance;
    if (!last_covariance(system, x, chain, state, covariance, result.velocity_sigma_m_per_s) ||
        !fill_information(covariance, result.initial)) {
        return Status::kDegenerate;
    }
    const int unknowns = static_cast<int>(system.h.rows()) - 1;  // |g| is known
    result.chi2_per_dof = system.squared_error / std::max(1, system.rows - unknowns);
    if (result.initial.tilt_sigma_rad > kMaxTiltSigma_rad ||
        result.velocity_sigma_m_per_s > config.max_velocity_sigma_m_per_s) {
        return Status::kDegenerate;
    }
    if (!(result.chi2_per_dof < kMaxChi2PerDof)) {
        return Status::kCorrupt;
    }
    out = result;
    return Status::kOk;
}

}  // namespace facet
