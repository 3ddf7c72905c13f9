// SPDX-License-Identifier: BSD-2-Clause
// What the estimator reports about a frame: each part fills its own share of the health.
#include <algorithm>
#include <cmath>

#include "estimator/api/estimator_impl.h"

namespace facet {

HealthEvidence Estimator::Impl::evidence(const StereoFrame& frame, bool frame_taken) const {
    HealthEvidence e;
    e.stamp = now.stamp;
    e.is_started = has_window(phase);
    e.is_unbroken = phase == Phase::kFollowing || phase == Phase::kHolding;
    e.has_frame = !is_blind;
    e.frame_taken = frame_taken;
    e.has_right = !frame.right.empty();
    e.lacks_right = rig.has_right && (is_exchanged ? frame.left : frame.right).empty();
    e.misses_camera = misses_camera(last_image);
    e.is_by_stamps = frame.is_by_stamps;
    e.stands = rest_claim == RestClaim::kSeen;
    e.is_confirmed = is_confirmed && !may_stand && rest_claim != RestClaim::kOpen && rest_claim != RestClaim::kRefuted;
    if (frame_taken && phase != Phase::kEmpty) {
        e.image = tracks.image;
        e.is_keyframe = tracks.is_keyframe;
        e.is_optimized = e.is_keyframe && !waits_at_newest_frame();
        e.tracked = std::max(tracks.tracked, static_cast<int>(tracks.observations.size()));
        e.stereo = tracks.stereo;
        e.fixed_share = tracks.fixed_share;
    }
    e.is_optimized = e.is_optimized || summary_is_new;
    e.newest_landmarks = window.state().keyframes.size() > 1 ? summary.newest_landmarks : e.tracked;
    e.imu = span;
    e.speed_m_per_s = now.state.v_W_B.norm();
    e.velocity_sigma_m_per_s = velocity_sigma(now);
    e.tilt_sigma_rad = tilt_sigma(now);
    e.gyro_bias_rad_per_s = now.state.bias.gyro.norm();
    e.accel_bias_m_per_s2 = now.state.bias.accel.norm();
    e.vision_chi2 = std::max(summary.fit.vision_chi2(config.window.pixel_sigma_px), frame_chi2);
    e.imu_chi2 = summary.imu_squared_error / kStateDim;
    e.residual_bias_px = window.residual_bias_px();
    e.calibration_stretch = window.calibration_stretch();
    e.solver_failed = summary.solver.solver_failed || summary.marginalization_failed || summary.prior_repaired;
    e.is_finite = is_finite(now);
    e.is_late = is_late;
    return e;
}

Eigen::Matrix<double, 9, 9> Estimator::Impl::reported_covariance() const {
    const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
    Eigen::Matrix<double, 9, 4> d = Eigen::Matrix<double, 9, 4>::Zero();
    d.block<3, 1>(kTheta, 0) = now.state.q_W_B.conjugate() * up;
    d.block<3, 1>(kPos, 0) = up.cross(now.state.p_W_B - gauge.origin_W);
    d.block<3, 3>(kPos, 1).setIdentity();
    d.block<3, 1>(kVel, 0) = up.cross(now.state.v_W_B);
    Eigen::Matrix<double, 9, 9> reported = now.covariance.topLeftCorner<9, 9>() + d * gauge.covariance * d.transpose();
    if (!(rests && tracks.is_still)) {  // else the velocity is known by other means
        add_ripple(imu, now.state, reported);
    }
    return reported;
}

void Estimator::Impl::report(const StereoFrame& frame, bool frame_taken, Estimate& estimate) {
    const HealthEvidence e = evidence(frame, frame_taken);
    is_late = is_late && !e.is_keyframe;
    summary_is_new = false;

    estimate = {};
    estimate.stamp = e.is_started ? now.stamp : frame.stamp;
    estimate.state = now.state;
    estimate.T_B_Bc = calibration_as_given().T_B_Bc;
    estimate.T_B_Bc_sigma = calibration_sigma.segment<6>(kRigTheta);
    Health& health = estimate.health;
    const bool was_lost = monitor.state() == TrackingState::kLost;
    monitor.update(e, health);
    if (was_lost && monitor.is_usable()) {
        count_reset();
        own_up_to_leap();
    }
    // What nobody has been given cannot be lost: a window that has gone astray begins anew, and the start goes on.
    health.state = is_first_start() && health.state == TrackingState::kLost ? TrackingState::kInit : health.state;
    estimate.covariance = reported_covariance();
    if (frame_taken && phase != Phase::kEmpty) {
        tracks.report(health);
        health.is_still = tracks.is_still && rests;
    }
    window.report(summary, health);
    health.time_offset_s = image_delay_s();
    health.mean_vision_chi2 = summary.fit.vision_chi2(config.window.pixel_sigma_px);
    health.map_landmarks = map_landmarks;
    health.frame_chi2 = frame_chi2;
    health.iterations = e.is_optimized ? summary.solver.iterations : 0;
    health.time_offset_sigma_s = calibration_sigma(kTimeOffset);
    health.reset_counter = reset_counter;
    health.is_exchanged = is_exchanged;
    imu.counters().report(health);
}

}  // namespace facet
