// SPDX-License-Identifier: BSD-2-Clause
// Judges from several independent signs whether the estimate can be used.
#pragma once

#include "estimator/api/estimate.h"
#include "estimator/api/health_config.h"
#include "estimator/frontend/frontend_types.h"
#include "estimator/imu/imu_buffer.h"

namespace facet {

/// The signs at one frame.
struct HealthEvidence {
    Timestamp stamp;
    bool is_started = false;     ///< there is a window
    bool is_unbroken = false;    ///< and inertial samples connect its keyframes with the newest state
    bool has_frame = true;       ///< false: carried on between frames that do not come; nothing is said of images then
    bool frame_taken = false;    ///< the front-end could work on the frame
    bool has_right = false;      ///< there is a pair of images
    bool lacks_right = false;    ///< there is a right camera, but no image of it
    bool misses_camera = false;  ///< one of two cameras has been silent for a while
    bool is_by_stamps = false;   ///< the frame is stamped by the cameras' own clocks, for want of trigger edges
    bool stands = false;         ///< a start at rest, which the images confirm
    bool is_confirmed = true;    ///< false: a start with one camera whose velocity no second opinion supports yet
    ImageState image = ImageState::kUsable;
    bool is_keyframe = false;
    bool is_optimized = false;       ///< the window has been optimized since the frame before, or begun
    int tracked = 0;                 ///< features in this frame
    int stereo = 0;                  ///< of those, with a stereo match; at keyframes
    bool is_left_out = false;        ///< the frame shows an emitter's dots, and has not been looked at
    bool leaves_out_frames = false;  ///< every second frame is left out for that
    double fixed_share = 0.0;        ///< of the image, left out because it moves with the vehicle
    int newest_landmarks = 0;        ///< landmarks that constrain the keyframe after optimization
    ImuSpan imu;                     ///< samples between the newest keyframe and the frame
    double speed_m_per_s = 0.0;
    double velocity_sigma_m_per_s = 0.0;  ///< largest of three axes, relative to the heading
    double tilt_sigma_rad = 0.0;          ///< larger of the two horizontal axes
    double gyro_bias_rad_per_s = 0.0;     ///< norm
    double accel_bias_m_per_s2 = 0.0;     ///< norm
    double vision_chi2 = 0.0;             ///< per degree of freedom
    double imu_chi2 = 0.0;                ///< per row, of the newest inertial factor
    double residual_bias_px = 0.0;        ///< largest mean of the residuals of an image coordinate
    double calibration_stretch = 0.0;     ///< largest correction of the calibration, in sigmas of what was given
    bool solver_failed = false;
    bool is_finite = true;
    bool lacks_range = false;  ///< a range finder is silent, or does not measure level ground
    bool is_late = false;      ///< work was cut because a frame came late
};

/// INIT until velocity and gravity are known; then TRACKING, DEGRADED when some sign is bad, and LOST when the estimate
/// must not be used: no vision for too long, an uncertain velocity for a second, an implausible speed or bias,
/// residuals that contradict the map, or values that are not finite. LOST ends when images return to a window that has
/// held, and it is then as sure as a start has to be; if its first keyframes with vision do not make it so, the state
/// has diverged, or inertial samples are missing since all was well, only restart() ends it. Thread-bound. No heap.
class HealthMonitor {
public:
    static constexpr int kFewStereo = 8;  ///< fewer matches say that two images do not belong together
    /// A lost window in which so many keyframes have seen enough, and that is still unsure, will not recover.
    static constexpr int kFruitlessKeyframes = 4;

    void configure(const HealthConfig& config) { config_ = config; }

    /// Before any data.
    void reset();

    /// A window begins at this stamp. @param is_known  velocity and gravity are known already: no INIT
    void restart(Timestamp stamp, bool is_known);

    /// Fills state, reasons and quality; the rest of `health` is the caller's.
    void update(const HealthEvidence& evidence, Health& health);

    TrackingState state() const { return state_; }
    /// The estimate may be used, well or badly.
    bool is_usable() const { return state_ == TrackingState::kTracking || state_ == TrackingState::kDegraded; }
    /// LOST for a reason that makes the state itself worthless, not merely outdated.
    bool has_diverged() const { return has_diverged_; }
    /// At the last frame nothing was known yet, or images and inertial readings disagreed.
    bool is_contradicted() const {
        return !is_usable() || (reasons_ & (kReasonHighResidual | kReasonImuContradicted)) != 0U;
    }
    /// LOST, and nothing but a new window will end it.
    bool needs_restart() const {
        return state_ == TrackingState::kLost &&
               (has_diverged_ || has_broken_ || fruitless_keyframes_ >= kFruitlessKeyframes);
    }

private:
    std::uint32_t reasons(const HealthEvidence& e) const;
    int quality(const HealthEvidence& e) const;
    double vision_age_s(Timestamp now) const { return (now - last_vision_).seconds(); }

    HealthConfig config_;
    TrackingState state_ = TrackingState::kInit;
    std::uint32_t reasons_ = 0;  ///< at the last update
    bool has_diverged_ = false;
    bool has_gap_ = false;     ///< inertial samples are missing since vision and velocity were in order
    bool has_broken_ = false;  ///< LOST, and that was so meanwhile
    Timestamp started_;
    Timestamp last_vision_;
    Timestamp last_sure_;          ///< the velocity was known well enough
    int wrong_keyframes_ = 0;      ///< in a row
    int fruitless_keyframes_ = 0;  ///< with enough features, since it is LOST
    bool has_pair_ = false;        ///< a keyframe had both images
    bool is_matched_ = false;      ///< and one had enough in common for stereo
};

}  // namespace facet
