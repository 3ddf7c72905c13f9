// SPDX-License-Identifier: BSD-2-Clause
// What the estimator reports about itself at one frame.
#pragma once

#include <cstdint>

namespace facet {

enum class TrackingState : std::uint8_t {
    kInit,      ///< collecting data; the state must not be used
    kTracking,  ///< all well
    kDegraded,  ///< running on little or no vision: usable, uncertain
    kLost,      ///< not to be used
};

constexpr const char* to_string(TrackingState s) {
    switch (s) {
        case TrackingState::kInit: return "INIT";
        case TrackingState::kTracking: return "TRACKING";
        case TrackingState::kDegraded: return "DEGRADED";
        case TrackingState::kLost: return "LOST";
    }
    return "?";
}

/// Why the state is what it is; bits of Health::reasons.
enum HealthReason : std::uint32_t {
    kReasonFewFeatures = 1U << 0,         ///< fewer tracked features than configured
    kReasonFewStereo = 1U << 1,           ///< fewer stereo matches than needed
    kReasonNoRightImage = 1U << 2,        ///< right frame missing
    kReasonImuGap = 1U << 3,              ///< inertial samples missing before this frame
    kReasonBiasLimit = 1U << 4,           ///< a bias beyond its plausible range
    kReasonHighResidual = 1U << 5,        ///< residuals of vision or the newest inertial factor are too large
    kReasonSolverFailed = 1U << 6,        ///< the linear system could not be solved
    kReasonImageRejected = 1U << 7,       ///< the image could not be used: wrong size
    kReasonImageDark = 1U << 8,           ///< hardly anything but black in it, or no contrast
    kReasonImageOverexposed = 1U << 9,    ///< hardly anything but white in it
    kReasonImageFrozen = 1U << 10,        ///< the previous image again, although the vehicle turned
    kReasonImuClipped = 1U << 11,         ///< readings at the IMU's range since the last keyframe
    kReasonVibration = 1U << 12,          ///< the IMU is shaken: its noise is raised
    kReasonSpeedLimit = 1U << 13,         ///< faster than the vehicle can fly
    kReasonVelocityUncertain = 1U << 14,  ///< velocity too uncertain for control
    kReasonOverrun = 1U << 15,            ///< a frame came late: less work is done until the next keyframe
    kReasonCalibration = 1U << 16,        ///< images contradict the calibration, or it had to be bent too far
    kReasonNoImages = 1U << 17,           ///< no frame comes: carried on by inertial data alone
    kReasonOneCamera = 1U << 18,          ///< one of two cameras has been silent for a while
    kReasonTriggerSilent = 1U << 19,      ///< no trigger edges: frames are stamped by the cameras' own clocks
    kReasonStalled = 1U << 20,            ///< live: the estimator does not answer; poses are carried on without it
    kReasonImuContradicted = 1U << 21,    ///< images contradict inertial readings, and are believed
    kReasonFixedPattern = 1U << 22,       ///< what moves with the vehicle is left out: a part, or every second image
    kReasonRange = 1U << 23,              ///< the range finder is silent, or does not measure level ground
};

/// One row of health.csv.
struct Health {
    TrackingState state = TrackingState::kInit;
    std::uint32_t reasons = 0;  ///< HealthReason bits
    int quality = 0;            ///< 0: must not be used; 1 to 100, best; low for a while after each start
    std::uint32_t reset_counter =
        0;  ///< restarts after an estimate to be used; when it rises, place or yaw may have jumped
    bool is_keyframe = false;
    bool is_exchanged = false;            ///< the right camera plays the left one, because that fails
    bool is_still = false;                ///< by images and inertial samples: the vehicle stands
    int tracked = 0;                      ///< features carried over from the previous frame
    int detected = 0;                     ///< new features
    int stereo = 0;                       ///< features with a right match
    int recalled = 0;                     ///< lost landmarks found again at this frame
    int outliers = 0;                     ///< rejected in the front-end at this frame
    double fixed_share = 0.0;             ///< of the image, left out because it moves with the vehicle
    int keyframes = 0;                    ///< in the window
    int landmarks = 0;                    ///< landmarks in the window that took part in the last optimization
    std::uint64_t landmarks_dropped = 0;  ///< since the start, for want of room: first those with the fewest sightings
    int iterations = 0;                   ///< solver steps at this frame
    int map_landmarks = 0;                ///< of the newest keyframe, found in this frame and used; 0 at keyframes
    double frame_chi2 = 0.0;              ///< variance of their residuals over the expected one, without outliers
    double mean_vision_chi2 = 0.0;  ///< squared vision residual per degree of freedom in units of the configured sigma
    double pixel_sigma_px = 0.0;    ///< standard deviation that observations are weighted with now
    double residual_bias_px = 0.0;  ///< largest mean of the residuals of an image coordinate; 0 until known
    double calibration_stretch = 0.0;  ///< largest correction of the calibration, in sigmas of what was given
    double calibration_scale = 1.0;    ///< learnt factor on all of those sigmas but the time offset's and the IMU's
    double imu_chi2 = 0.0;       ///< squared whitened residual per degree of freedom of the newest inertial factor
    double time_offset_s = 0.0;  ///< estimated: image stamps plus this are the IMU's time
    double time_offset_sigma_s = 0.0;  ///< 0 if it is not estimated
    std::uint64_t imu_gaps = 0;        ///< gaps since start
    std::uint64_t imu_clipped = 0;     ///< samples at the IMU's range since start
    std::uint64_t imu_dropped = 0;     ///< samples dropped since start: out of order, duplicate, not finite, or full
};

}  // namespace facet
