// SPDX-License-Identifier: BSD-2-Clause
// What is reported about a frame, each part filling its own share of the health; and what outlives a program.
#include <algorithm>
#include <cmath>

#include "estimator/flight/belief_changes.h"
#include "estimator/flight/flight.h"

namespace facet {

HealthEvidence FlightEstimator::evidence(const StereoFrame& frame, FrameUse use) const {
    const WindowSummary& summary = s_.keyframe.summary;
    HealthEvidence e;
    e.stamp = s_.now.stamp;
    e.is_started = has_window(s_.phase);
    e.is_unbroken = s_.phase == Phase::kFollowing || s_.phase == Phase::kHolding;
    e.has_frame = use != FrameUse::kMissing;
    e.frame_taken = use == FrameUse::kTracked;
    e.is_left_out = use == FrameUse::kLeftOut;
    e.leaves_out_frames = s_.emitter.is_alternating();
    e.has_right = !frame.right.empty();
    e.lacks_right = cameras_.rig().has_right && (cameras_.is_exchanged() ? frame.left : frame.right).empty();
    e.misses_camera = cameras_.misses_camera(s_.frames.last_image);
    e.is_by_stamps = frame.is_by_stamps;
    e.stands = s_.start.claim() == RestClaim::kSeen;
    e.is_confirmed = !s_.start.is_open() && !delay_.is_in_doubt();
    if (e.frame_taken && s_.phase != Phase::kEmpty) {
        e.image = tracks_.image;
        e.is_keyframe = tracks_.is_keyframe;
        e.is_optimized = e.is_keyframe && !waits_at_newest_frame();
        e.tracked = std::max(tracks_.tracked, static_cast<int>(tracks_.observations.size()));
        e.stereo = tracks_.stereo;
        e.fixed_share = tracks_.fixed_share;
    }
    if (e.is_left_out) {
        e.tracked = tracks_.tracked;  // as many as in the frame before it
    }
    e.is_optimized = e.is_optimized || s_.keyframe.is_new;
    e.newest_landmarks = window_.state().keyframes.size() > 1 ? summary.newest_landmarks : e.tracked;
    e.imu = s_.span;
    e.speed_m_per_s = s_.now.state.v_W_B.norm();
    e.velocity_sigma_m_per_s = velocity_sigma(s_.now);
    e.tilt_sigma_rad = tilt_sigma(s_.now);
    e.gyro_bias_rad_per_s = s_.now.state.bias.gyro.norm();
    e.accel_bias_m_per_s2 = s_.now.state.bias.accel.norm();
    e.vision_chi2 = std::max(summary.fit.vision_chi2(config_.window.pixel_sigma_px), s_.fit.chi2);
    e.imu_chi2 = summary.imu_squared_error / kStateDim;
    e.residual_bias_px = window_.residual_bias_px();
    e.calibration_stretch = window_.calibration_stretch();
    e.solver_failed = summary.solver.solver_failed || summary.marginalization_failed || summary.prior_replaced;
    e.is_finite = is_finite(s_.now);
    e.is_late = s_.is_late;
    e.lacks_range = window_.doubts_ground() || ranges_.are_missing(s_.now.stamp);
    return e;
}

void FlightEstimator::report(const StereoFrame& frame, FrameUse use, Estimate& estimate) {
    const HealthEvidence e = evidence(frame, use);
    s_.is_late = s_.is_late && !e.is_keyframe;
    s_.keyframe.is_new = false;

    estimate = {};
    estimate.stamp = e.is_started ? s_.now.stamp : frame.stamp;
    estimate.state = s_.now.state;
    estimate.T_B_Bc = cameras_.as_given(window_.calibration()).T_B_Bc;
    estimate.T_B_Bc_sigma = s_.calibration_sigma.segment<6>(kRigTheta);
    Health& health = estimate.health;
    const bool was_lost = monitor_.state() == TrackingState::kLost;
    monitor_.update(e, health);
    if (was_lost && monitor_.is_usable()) {
        s_.resets.jump();
        s_.gauge.add_leap(s_.now.state.p_W_B);
    }
    // What nobody has been given cannot be lost: a window that has gone astray begins anew, and the start goes on.
    const bool is_lost = health.state == TrackingState::kLost;
    health.state = is_lost && s_.resets.is_first_start() ? TrackingState::kInit : health.state;
    estimate.covariance = reported_covariance();
    if (e.frame_taken && s_.phase != Phase::kEmpty) {
        tracks_.report(health);
        health.is_still = tracks_.is_still && s_.rest.rests();
    }
    const WindowSummary& summary = s_.keyframe.summary;
    window_.report(summary, health);
    health.time_offset_s = image_delay_s();
    health.mean_vision_chi2 = summary.fit.vision_chi2(config_.window.pixel_sigma_px);
    health.map_landmarks = s_.fit.landmarks;
    health.frame_chi2 = s_.fit.chi2;
    health.iterations = e.is_optimized ? summary.solver.iterations : 0;
    health.time_offset_sigma_s = s_.calibration_sigma(kTimeOffset);
    health.reset_counter = s_.resets.value();
    health.is_exchanged = cameras_.is_exchanged();
    imu_.counters().report(health);
}

Eigen::Matrix<double, 9, 9> FlightEstimator::reported_covariance() const {
    const NavState& state = s_.now.state;
    const Gauge& gauge = s_.gauge.gauge();
    const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
    Eigen::Matrix<double, 9, 4> d = Eigen::Matrix<double, 9, 4>::Zero();
    d.block<3, 1>(kTheta, 0) = state.q_W_B.conjugate() * up;
    d.block<3, 1>(kPos, 0) = up.cross(state.p_W_B - gauge.origin_W);
    d.block<3, 3>(kPos, 1).setIdentity();
    d.block<3, 1>(kVel, 0) = up.cross(state.v_W_B);
    Eigen::Matrix<double, 9, 9> reported =
        s_.now.covariance.topLeftCorner<9, 9>() + d * gauge.covariance * d.transpose();
    if (!(s_.rest.rests() && tracks_.is_still)) {  // else the velocity is known by other means
        add_ripple(imu_, state, reported);
    }
    return reported;
}

CalibrationEstimate FlightEstimator::calibration() {
    CalibrationEstimate estimate;
    estimate.correction = cameras_.as_given(window_.calibration());
    estimate.correction.time_offset_s = image_delay_s();
    for (int i = 0; i < config_.calibration.dim() && window_.has_factor(); ++i) {
        estimate.sigma(i) = window_.calibration_sigma(i);
    }
    if (cameras_.is_exchanged()) {
        estimate.sigma.segment<kLensDim>(kLeftLens).swap(estimate.sigma.segment<kLensDim>(kRightLens));
    }
    return estimate;
}

KeptState FlightEstimator::keep() {
    KeptState kept;
    kept.state = s_.now.state;
    StateCovariance covariance = s_.now.covariance;
    covariance.topLeftCorner<9, 9>() = reported_covariance();
    kept.sigma = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
    kept.calibration = calibration();
    if (!window_.has_factor()) {  // nothing has been found yet, but by an earlier program
        kept.calibration.sigma = s_.calibration_sigma;
    }
    return kept;
}

Status FlightEstimator::resume(const KeptState& kept, double elapsed_s) {
    constexpr double kInflation = 2.0;
    Belief belief;
    belief.state = kept.state;
    belief.covariance.diagonal() = kept.sigma.cwiseAbs2();
    const double norm = kept.state.q_W_B.norm();
    if (!is_finite(belief) || !(kept.sigma.array() > 0.0).all() || !(std::abs(norm - 1.0) < 1e-3) ||
        !(elapsed_s >= 0.0) || !std::isfinite(elapsed_s)) {
        return Status::kInvalidArgument;
    }
    if (!kept.calibration.sigma.isZero(0.0)) {
        FACET_TRY(window_.resume_calibration(kept.calibration.correction, kept.calibration.sigma));
        s_.calibration_sigma = kInflation * kept.calibration.sigma;
        update_corrections();
    }
    belief.state.q_W_B.normalize();
    belief.covariance.bottomRightCorner<6, 6>() *= kInflation * kInflation;
    widen_after_unknown(s_.fault.rate_B(), elapsed_s, belief);
    s_.trusted = belief;
    return Status::kOk;
}

}  // namespace facet
