// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/flight/health_monitor.h"

#include <algorithm>
#include <cmath>

namespace facet {
namespace {

// Vibration of the accelerometer above this raises a warning (m/s^2).
constexpr double kVibration_m_per_s2 = 3.0;
// A start is complete only when the standard deviation of the direction of gravity is below this (rad).
constexpr double kReadyTiltSigma_rad = 0.05;
// A start is complete only when the standard deviation of the velocity is below this (m/s).
constexpr double kReadyVelocitySigma_m_per_s = 0.1;
// An estimated gyroscope bias above this is divergence: lost (rad/s).
constexpr double kMaxGyroBias_rad_per_s = 0.5;
constexpr int kFewLandmarks = 8;
constexpr int kWrongKeyframes = 3;
/// Velocity may be uncertain for this long while vision holds the pose: clipped samples hide it for some frames.
constexpr double kUnsureFor = 1.0;  // s
/// This many tracked features make vision as good as it gets, for the quality.
constexpr double kManyFeatures = 60.0;
constexpr double kGraceQuality = 0.3;
constexpr double kFaultQuality = 0.5;

constexpr std::uint32_t kDegrading = kReasonFewFeatures | kReasonImageRejected | kReasonImageDark |
                                     kReasonImageOverexposed | kReasonImageFrozen | kReasonBiasLimit |
                                     kReasonHighResidual | kReasonSolverFailed | kReasonVelocityUncertain |
                                     kReasonImuClipped | kReasonImuGap | kReasonSpeedLimit | kReasonNoImages |
                                     kReasonOneCamera | kReasonTriggerSilent | kReasonImuContradicted;

}  // namespace

void HealthMonitor::reset() {
    state_ = TrackingState::kInit;
    reasons_ = 0;
    has_diverged_ = has_gap_ = has_broken_ = false;
    wrong_keyframes_ = fruitless_keyframes_ = 0;
    has_pair_ = is_matched_ = false;
    started_ = last_vision_ = last_sure_ = {};
}

void HealthMonitor::restart(Timestamp stamp, bool is_known) {
    reset();
    state_ = is_known ? TrackingState::kTracking : TrackingState::kInit;
    started_ = last_vision_ = last_sure_ = stamp;
}

std::uint32_t HealthMonitor::reasons(const HealthEvidence& e) const {
    std::uint32_t bits = 0;
    const auto raise = [&bits](bool condition, HealthReason reason) { bits |= condition ? reason : 0U; };
    raise(!e.has_frame, kReasonNoImages);
    raise(e.fixed_share > 0.0 || e.leaves_out_frames, kReasonFixedPattern);
    if (e.has_frame && !e.is_left_out) {
        raise(!e.frame_taken, kReasonImageRejected);
        raise(e.image == ImageState::kDark || e.image == ImageState::kFlat, kReasonImageDark);
        raise(e.image == ImageState::kOverexposed, kReasonImageOverexposed);
        raise(e.image == ImageState::kFrozen, kReasonImageFrozen);
        raise(e.tracked < HealthConfig::kFewFeatures || (e.is_optimized && e.newest_landmarks < kFewLandmarks),
              kReasonFewFeatures);
        raise(e.is_keyframe && e.has_right && e.stereo < kFewStereo, kReasonFewStereo);
        raise(e.lacks_right, kReasonNoRightImage);
        raise(e.is_by_stamps, kReasonTriggerSilent);
    }
    raise(e.misses_camera, kReasonOneCamera);
    raise(e.imu.has_gap, kReasonImuGap);
    raise(e.imu.clipped != 0, kReasonImuClipped);
    raise(e.imu.is_replaced, kReasonImuContradicted);
    raise(e.imu.accel_vibration_m_per_s2 > kVibration_m_per_s2, kReasonVibration);
    raise(
        e.gyro_bias_rad_per_s > kMaxGyroBias_rad_per_s || e.accel_bias_m_per_s2 > HealthConfig::kMaxAccelBias_m_per_s2,
        kReasonBiasLimit);
    raise(e.speed_m_per_s > config_.max_speed_m_per_s, kReasonSpeedLimit);
    raise(e.velocity_sigma_m_per_s > HealthConfig::kMaxVelocitySigma_m_per_s, kReasonVelocityUncertain);
    raise(std::max(e.vision_chi2, e.imu_chi2) > config_.high_vision_chi2, kReasonHighResidual);
    raise(e.solver_failed || !e.is_finite, kReasonSolverFailed);
    raise(e.is_late, kReasonOverrun);
    raise(e.lacks_range, kReasonRange);
    raise(e.residual_bias_px > HealthConfig::kMaxResidualBias_px ||
              e.calibration_stretch > HealthConfig::kMaxCalibrationStretch,
          kReasonCalibration);
    return bits;
}

int HealthMonitor::quality(const HealthEvidence& e) const {
    if (!is_usable()) {
        return 0;
    }
    const double share[] = {
        e.tracked / kManyFeatures,
        e.velocity_sigma_m_per_s > 0.0 ? 0.2 * HealthConfig::kMaxVelocitySigma_m_per_s / e.velocity_sigma_m_per_s : 1.0,
        e.vision_chi2 > 0.0 ? config_.high_vision_chi2 / e.vision_chi2 : 1.0,
        e.imu_chi2 > config_.high_vision_chi2 ? config_.high_vision_chi2 / e.imu_chi2 : 1.0,
        e.residual_bias_px > HealthConfig::kMaxResidualBias_px ? HealthConfig::kMaxResidualBias_px / e.residual_bias_px
                                                               : 1.0,
        e.calibration_stretch > HealthConfig::kMaxCalibrationStretch
            ? HealthConfig::kMaxCalibrationStretch / e.calibration_stretch
            : 1.0,
    };
    // With a calibration or readings suspected the claimed covariance is too, so that half is the best. Two images that
    // have had nothing in common since the start are such a calibration (cameras exchanged), or leave scale to the IMU.
    const bool is_replaced = share[4] < 1.0 || share[5] < 1.0 || e.imu.is_replaced || (has_pair_ && !is_matched_);
    const double best = is_replaced ? kFaultQuality : 1.0;
    double worst = (e.stamp - started_).seconds() < HealthConfig::kGrace_s ? kGraceQuality : 1.0;
    // Inertial data alone are good for a while: features count in proportion to how long they have been missing.
    const double age = std::clamp(vision_age_s(e.stamp) / config_.lost_after_s, 0.0, 1.0);
    worst = std::min(
        {worst, std::max(share[0], 0.5 * (1.0 - age)), share[1], share[2], share[3], share[4], share[5], best});
    return std::clamp(static_cast<int>(std::lround(100.0 * worst)), 1, 100);
}

void HealthMonitor::update(const HealthEvidence& e, Health& health) {
    health.reasons = e.is_started ? reasons(e) : 0U;
    if (e.is_started) {
        const bool sees_enough =
            e.has_frame && e.frame_taken && e.image == ImageState::kUsable && e.tracked >= HealthConfig::kFewFeatures;
        const bool has_vision = sees_enough && (health.reasons & kReasonFewFeatures) == 0U;
        last_vision_ = has_vision ? e.stamp : last_vision_;
        if (e.is_optimized) {
            wrong_keyframes_ = e.vision_chi2 > HealthConfig::kWrongVisionChi2 ? wrong_keyframes_ + 1 : 0;
        }
        if (e.is_keyframe) {
            has_pair_ = has_pair_ || e.has_right;
            is_matched_ = is_matched_ || e.stereo >= kFewStereo;
        }
        const bool diverged = (health.reasons & (kReasonBiasLimit | kReasonSpeedLimit)) != 0U ||
                              wrong_keyframes_ >= kWrongKeyframes || !e.is_finite;
        const bool blind = vision_age_s(e.stamp) > config_.lost_after_s;
        if (state_ == TrackingState::kInit ||
            e.velocity_sigma_m_per_s < 2.0 * HealthConfig::kMaxVelocitySigma_m_per_s) {
            last_sure_ = e.stamp;
        }
        has_gap_ = e.imu.has_gap || (has_gap_ && !(last_vision_ == e.stamp && last_sure_ == e.stamp));
        const bool unsure = (e.stamp - last_sure_).seconds() > kUnsureFor;
        const bool is_ready = e.velocity_sigma_m_per_s < kReadyVelocitySigma_m_per_s &&
                              e.tilt_sigma_rad < kReadyTiltSigma_rad && has_vision && e.is_optimized &&
                              e.vision_chi2 < config_.high_vision_chi2 && e.is_confirmed;
        fruitless_keyframes_ += sees_enough && e.is_optimized ? 1 : 0;
        if (diverged || blind || unsure) {
            fruitless_keyframes_ = state_ == TrackingState::kLost ? fruitless_keyframes_ : 0;
            state_ = TrackingState::kLost;
            has_diverged_ = has_diverged_ || diverged;
            has_broken_ = has_broken_ || has_gap_;
        } else if (state_ == TrackingState::kLost) {
            const bool has_recovered =
                is_ready && e.is_unbroken && !has_diverged_ && !has_broken_ && config_.auto_reset;
            state_ = has_recovered ? TrackingState::kTracking : TrackingState::kLost;
        } else if (state_ == TrackingState::kInit) {
            state_ = is_ready || (e.stands && has_vision) ? TrackingState::kTracking : TrackingState::kInit;
        }
        if (is_usable()) {
            state_ = (health.reasons & kDegrading) != 0U ? TrackingState::kDegraded : TrackingState::kTracking;
        }
    }
    reasons_ = health.reasons;
    health.state = state_;
    health.quality = quality(e);
}

}  // namespace facet
