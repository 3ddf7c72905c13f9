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
    e.frame_taken = frame_taken;
    e.has_right = !frame.right.empty();
    if (frame_taken && phase != Phase::kEmpty) {
        e.image = tracks.image;
        e.is_keyframe = tracks.is_keyframe;
        e.tracked = static_cast<int>(tracks.observations.size());
        e.stereo = tracks.stereo;
    }
    e.newest_landmarks = window.state().keyframes.size() > 1 ? summary.newest_landmarks : e.tracked;
    e.imu = span;
    e.speed_m_per_s = now.state.v_W_B.norm();
    e.velocity_sigma_m_per_s = std::sqrt(now.covariance.diagonal().segment<3>(kVel).maxCoeff());
    e.tilt_sigma_rad = tilt_sigma(now);
    e.gyro_bias_rad_per_s = now.state.bias.gyro.norm();
    e.accel_bias_m_per_s2 = now.state.bias.accel.norm();
    e.vision_chi2 = std::max(summary.fit.vision_chi2(config.window.pixel_sigma_px), frame_chi2);
    e.residual_bias_px = window.residual_bias_px();
    e.calibration_stretch = window.calibration_stretch();
    e.solver_failed = summary.solver.solver_failed || summary.marginalization_failed;
    e.is_finite = is_finite(now);
    e.is_late = is_late;
    return e;
}

void Estimator::Impl::report(const StereoFrame& frame, bool frame_taken, Estimate& estimate) {
    const HealthEvidence e = evidence(frame, frame_taken);
    is_late = is_late && !e.is_keyframe;

    estimate = {};
    estimate.stamp = e.is_started ? now.stamp : frame.stamp;
    estimate.state = now.state;
    estimate.covariance = now.covariance.topLeftCorner<9, 9>();
    estimate.T_B_Bc = window.calibration().T_B_Bc;
    estimate.T_B_Bc_sigma = calibration_sigma.segment<6>(kRigTheta);
    Health& health = estimate.health;
    monitor.update(e, health);
    if (frame_taken && phase != Phase::kEmpty) {
        tracks.report(health);
        health.is_still = tracks.is_still && rests;
    }
    window.report(summary, health);
    health.mean_vision_chi2 = summary.fit.vision_chi2(config.window.pixel_sigma_px);
    health.map_landmarks = map_landmarks;
    health.frame_chi2 = frame_chi2;
    health.iterations = e.is_keyframe ? summary.solver.iterations : 0;
    health.time_offset_sigma_s = calibration_sigma(kTimeOffset);
    health.reset_counter = reset_counter;
    imu.counters().report(health);
}

}  // namespace facet
