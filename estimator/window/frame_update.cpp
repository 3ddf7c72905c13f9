// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/frame_update.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "estimator/window/plain_loss.h"
#include "estimator/window/vision_noise.h"

namespace facet {
namespace {

constexpr int kSteps = 4;
constexpr double kNegligibleStep = 1e-6;   // rad, m, m/s
constexpr double kFirstThreshold = 1.5;    // of Huber's loss in the first step, before the state is roughly right
constexpr double kSettledThreshold = 1.2;  // of Cauchy's afterwards, in standard deviations: as in the window
constexpr double kAgreeing = 9.0;          // squared

}  // namespace

TrackMemory TrackMemory::after(double dt_s) {
    const double correlation = kSlow * std::exp(-dt_s / kMemory_s);
    return {correlation, (1.0 - correlation * correlation) / VisionNoise::kDependence};
}

void FrameUpdate::collect(const LocalMap& map, const WindowCameras& cameras, int newest,
                          std::span<const FeatureObservation> observations) {
    sights_.clear();
    for (const FeatureObservation& o : observations) {
        const MapPoint* point = map.find(o.landmark);
        if (point != nullptr && sights_.size() < sights_.capacity()) {
            Sight sight{point, cameras.observe(newest, o).measurement};
            sight.measurement.has_right = false;
            sights_.push_back(sight);
        }
    }
}

Status linearize_sight(const MapPoint& p, const StereoMeasurement& left, const StereoGeometry& geometry,
                       const RelativeView& view, const Eigen::Matrix3d& R_B_W, const TrackMemory& memory,
                       const Eigen::Matrix<double, kPoseDim, 1>& newest_step, SightResidual& out) {
    const StereoView views{view, {}};
    StereoLinearization l;
    FACET_TRY(linearize_stereo(left, geometry, views, views, R_B_W, p.point, kPlainLoss, nullptr, l));
    const Eigen::Matrix<double, 2, 3> d_r_d_point = l.d_r_d_point.topRows<2>();
    out.d_r_d_newest.noalias() = d_r_d_point.lazyProduct(p.d_point_d_pose) - memory.correlation * p.d_residual_d_pose;
    out.d_r_d_frame = l.d_r_d_T_W_B_transposed.topLeftCorner<kPoseDim, 2>().transpose();
    out.r = l.r.head<2>() - memory.correlation * p.residual;
    out.r.noalias() += out.d_r_d_newest.lazyProduct(newest_step);
    const Eigen::Matrix<double, 2, 3> m = d_r_d_point - memory.correlation * p.d_residual_d_point;
    const Eigen::Matrix<double, 2, 3> mc = m.lazyProduct(p.covariance);
    out.covariance.noalias() = mc.lazyProduct(m.transpose());
    out.covariance.diagonal().array() += memory.fresh_variance / p.weight;
    return Status::kOk;
}

void FrameUpdate::add_sight(const SightResidual& sight, const RobustLoss& loss) {
    // Whitened by the Cholesky factor of the covariance.
    const double i0 = 1.0 / std::sqrt(spread_ * sight.covariance(0, 0));
    const double l10 = spread_ * sight.covariance(1, 0) * i0;
    const double i1 = 1.0 / std::sqrt(spread_ * sight.covariance(1, 1) - l10 * l10);
    Eigen::Matrix<double, 2, 2 * kPoseDim> j;
    j << sight.d_r_d_newest, sight.d_r_d_frame;
    Eigen::Vector2d r = sight.r;
    r(0) *= i0;
    r(1) = (r(1) - l10 * r(0)) * i1;
    j.row(0) *= i0;
    j.row(1) = (j.row(1) - l10 * j.row(0)) * i1;
    const double square = r.squaredNorm();
    if (!std::isfinite(square)) {
        return;
    }
    agreeing_ += square * spread_ < kAgreeing ? 1 : 0;
    const double weight = loss.weight(square);
    sums_ += {1, square, weight, loss.slope(square), weight * weight * square};
    const Eigen::Matrix<double, 2 * kPoseDim, 2> jw = weight * j.transpose();
    pose_h_.noalias() += jw.lazyProduct(j);
    pose_g_.noalias() += jw.lazyProduct(r);
}

void FrameUpdate::add_images(const WindowCameras& cameras, int keyframes, const NavState& state,
                             const RobustLoss& loss) {
    const CameraPose camera = cameras.left_of(state);
    views_.clear();
    for (int k = 0; k < keyframes; ++k) {
        views_.push_back(RelativeView::of(camera, cameras.left(k)));
    }
    pose_h_.setZero();
    pose_g_.setZero();
    sums_ = {};
    agreeing_ = 0;
    const Eigen::Matrix3d R_B_W = state.q_W_B.toRotationMatrix().transpose();
    for (const Sight& sight : sights_) {
        SightResidual residual;
        if (ok(linearize_sight(*sight.point, sight.measurement, cameras.geometry(),
                               views_[static_cast<std::size_t>(sight.point->host)], R_B_W, memory_,
                               newest_step_.head<kPoseDim>(), residual))) {
            add_sight(residual, loss);
        }
    }
}

/// Variance of the M-estimate over that of the residuals as modelled: E[rho'] E[psi^2] / E[psi']^2 per coordinate.
double FrameUpdate::measured_spread() const {
    const int rows = 2 * sums_.points - kPoseDim;
    const double spread =
        sums_.weight * sums_.squared_influence / (sums_.slope * sums_.slope) * sums_.points / std::max(1, rows);
    return std::isfinite(spread) ? spread : 1.0;
}

/// Sums the inertial terms, the keyframe's own and those of the images.
void FrameUpdate::assemble(const LocalMap& map, const ImuFactorLinearization& imu) {
    h_.topLeftCorner<kStateDim, kStateDim>() = map.newest_information();
    h_.topLeftCorner<kStateDim, kStateDim>().noalias() += imu.d_r_d_i.transpose() * imu.d_r_d_i;
    h_.bottomLeftCorner<kStateDim, kStateDim>().noalias() = imu.d_r_d_j.transpose() * imu.d_r_d_i;
    h_.bottomRightCorner<kStateDim, kStateDim>().noalias() = imu.d_r_d_j.transpose() * imu.d_r_d_j;
    g_.head<kStateDim>().noalias() = map.newest_information() * newest_step_;
    g_.head<kStateDim>().noalias() += imu.d_r_d_i.transpose() * imu.r;
    g_.tail<kStateDim>().noalias() = imu.d_r_d_j.transpose() * imu.r;
    for (int b = 0; b < 2; ++b) {
        g_.segment<kPoseDim>(kStateDim * b) += pose_g_.segment<kPoseDim>(kPoseDim * b);
        for (int c = 0; c <= b; ++c) {
            h_.block<kPoseDim, kPoseDim>(kStateDim * b, kStateDim * c) +=
                pose_h_.block<kPoseDim, kPoseDim>(kPoseDim * b, kPoseDim * c);
        }
    }
}

Status FrameUpdate::solve(const LocalMap& map, const WindowCameras& cameras, int keyframes,
                          const FramePrediction& prediction, std::span<const FeatureObservation> observations,
                          FrameEstimate& out) {
    collect(map, cameras, keyframes - 1, observations);
    ImuFactor factor;
    FACET_TRY(factor.set(prediction.since_newest, prediction.noise));
    memory_ = TrackMemory::after(prediction.since_newest.dt_s());
    newest_step_.setZero();
    NavState state = prediction.state;
    double spread = 1.0;
    ImuFactorLinearization imu;
    Vector step;
    for (int i = 0; i < kSteps; ++i) {
        spread_ = spread;
        const RobustLoss loss =
            i == 0 ? RobustLoss{kFirstThreshold, LossKind::kHuber} : RobustLoss{kSettledThreshold, LossKind::kCauchy};
        add_images(cameras, keyframes, state, loss);
        if (sums_.points < kMinLandmarks) {
            return Status::kNotFound;
        }
        const NavState newest = prediction.newest.box_plus(newest_step_);
        factor.linearize(newest, state, newest, state, imu);
        assemble(map, imu);
        llt_.compute(h_);
        if (llt_.info() != Eigen::Success) {
            return Status::kDegenerate;
        }
        step = -llt_.solve(g_);
        newest_step_ += step.head<kStateDim>();
        state = state.box_plus(step.tail<kStateDim>());
        // Residuals before the first step tell of the prediction's error, not of the images'.
        spread = i == 0 ? 1.0 : std::max(1.0, spread_ * measured_spread());
        if (i > 1 && step.cwiseAbs().maxCoeff() < kNegligibleStep) {
            break;
        }
    }
    FACET_TRY(finish(map, prediction, state, out));
    out.inertial_chi2 = inertial_error(map, imu, step) / kPoseDim;
    return Status::kOk;
}

/// What the inertial samples, and what is known of the newest keyframe, contradict of the solution.
/// @param imu, step  the last linearization, and the step from it
double FrameUpdate::inertial_error(const LocalMap& map, const ImuFactorLinearization& imu, const Vector& step) const {
    const Eigen::Matrix<double, kStateDim, 1> r =
        imu.r + imu.d_r_d_i * step.head<kStateDim>() + imu.d_r_d_j * step.tail<kStateDim>();
    return r.squaredNorm() + newest_step_.dot(map.newest_information() * newest_step_);
}

/// B (P_k - E) B^T.
/// @param root  inverse of the last block of H's Cholesky factor
StateCovariance FrameUpdate::shared_drift(const LocalMap& map, const FramePrediction& prediction, const NavState& state,
                                          const StateCovariance& root) const {
    const NavState newest = prediction.newest.box_plus(newest_step_);
    const Eigen::Matrix3d R_W_Bk = newest.q_W_B.toRotationMatrix();
    const double dt_s = prediction.since_newest.dt_s();
    constexpr int kMapDim = kPoseDim + 3;
    static_assert(kVel == kPoseDim);
    Eigen::Matrix<double, 2 * kPoseDim, kMapDim> shared;  // [I 0; G]
    shared.setIdentity();
    auto g = shared.bottomRows<kPoseDim>();
    g.setIdentity();
    g.block<3, 3>(kTheta, kTheta) = state.q_W_B.toRotationMatrix().transpose() * R_W_Bk;
    g.block<3, 3>(kPos, kTheta) = skew(dt_s * newest.v_W_B - (state.p_W_B - newest.p_W_B)) * R_W_Bk;
    g.block<3, 3>(kPos, kVel) = dt_s * Eigen::Matrix3d::Identity();
    const Eigen::Matrix<double, 2 * kPoseDim, kMapDim> pull = pose_h_ * shared;
    Eigen::Matrix<double, kDim, kStateDim> b = Eigen::Matrix<double, kDim, kStateDim>::Zero();
    b.topRows<kStateDim>() = map.newest_information();
    b.topLeftCorner<kPoseDim, kMapDim>() += pull.topRows<kPoseDim>();
    b.block<kPoseDim, kMapDim>(kStateDim, 0) = pull.bottomRows<kPoseDim>();
    llt_.matrixL().solveInPlace(b);
    const StateCovariance answer = root.transpose() * b.bottomRows<kStateDim>();
    return answer * (prediction.covariance - map.newest_covariance()) * answer.transpose();
}

Status FrameUpdate::finish(const LocalMap& map, const FramePrediction& prediction, const NavState& state,
                           FrameEstimate& out) const {
    // The frame's state is last: the last block of L^-T L^-1.
    StateCovariance root = StateCovariance::Identity();
    llt_.matrixLLT().bottomRightCorner<kStateDim, kStateDim>().triangularView<Eigen::Lower>().solveInPlace(root);
    StateCovariance covariance = root.transpose() * root;
    covariance += shared_drift(map, prediction, state, root);
    const bool is_sound = covariance.allFinite() && (covariance.diagonal().array() > 0.0).all() &&
                          state.q_W_B.coeffs().allFinite() && state.p_W_B.allFinite() && state.v_W_B.allFinite();
    if (!is_sound) {
        return Status::kDegenerate;
    }
    out.state = state;
    out.covariance = covariance;
    out.landmarks = sums_.points;
    out.agreeing = agreeing_;
    out.chi2 = spread_ * measured_spread();
    return Status::kOk;
}

}  // namespace facet
