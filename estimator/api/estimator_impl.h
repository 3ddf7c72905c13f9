// SPDX-License-Identifier: BSD-2-Clause
// The estimator's parts and how they work together; private to estimator/api.
#pragma once

#include "estimator/api/belief.h"
#include "estimator/api/estimator.h"
#include "estimator/api/health_monitor.h"
#include "estimator/api/motion_start.h"
#include "estimator/api/phase.h"
#include "estimator/frontend/frontend.h"
#include "estimator/imu/imu_buffer.h"
#include "estimator/imu/propagation.h"
#include "estimator/values/camera_corrections.h"
#include "estimator/window/frame_update.h"
#include "estimator/window/local_map.h"
#include "estimator/window/window.h"

namespace facet {

struct Estimator::Impl {
    EstimatorConfig config;
    StereoRig rig;
    double gravity_m_per_s2 = 0.0;
    StageObserver* observer = nullptr;
    ObservationHook* hook = nullptr;
    ImuBuffer imu;
    Frontend frontend;
    FrontendOutput tracks;
    Window window;
    LocalMap map;  ///< of the newest keyframe
    FrameUpdate frame_update;
    HealthMonitor monitor;
    MotionStart motion_start;
    Belief newest;  ///< at the newest keyframe
    Belief now;     ///< at the newest frame
    ImuSpan span;   ///< samples between them
    Phase phase = Phase::kEmpty;
    bool rests = false;         ///< by inertial samples and images: at rest at every frame since the newest keyframe
    bool reset_wanted = false;  ///< requested by the user
    bool is_late = false;       ///< a frame took too long: less work up to the next keyframe
    Timestamp last_image;       ///< stamp of the last frame as given
    CameraCorrections corrections;  ///< that the front-end works with
    RigCalibration::Tangent calibration_sigma = RigCalibration::Tangent::Zero();
    std::uint32_t reset_counter = 0;
    WindowSummary summary;
    int map_landmarks = 0;    ///< that the newest frame was compared with
    double frame_chi2 = 0.0;  ///< of that comparison
    KeyframeView view;        ///< landmarks at the newest keyframe

    void reset();
    /// Stamp of an image in the IMU's clock.
    Timestamp imu_stamp(Timestamp image) const {
        return image + Duration::from_seconds(window.calibration().time_offset_s);
    }
    KeyframeInput keyframe_input() const;
    Status start(const StereoFrame& frame, Estimate& estimate);
    /// Fills `now` and `span` from the newest keyframe, or from the last frame if that is out of reach.
    Status predict(Timestamp stamp, Preintegration& preintegration);
    Status track(const StereoFrame& frame, Timestamp before, bool wants_keyframe);
    void judge_rest(bool image_is_still);
    /// The vehicle stands where it stood at the newest keyframe: that is known better than the inertial prediction
    /// since, which has the errors of velocity and biases.
    void hold_still();
    /// Corrects the predicted state by the frame's image, if that sees enough of the map.
    /// @param preintegration  from the newest keyframe to now
    void update_by_image(const Preintegration& preintegration);
    void take_keyframe(const Preintegration& preintegration);
    /// During a start in motion: if the window contradicts the closed-form solution, it begins anew from that solution.
    void second_opinion();
    /// Begins a window with one keyframe, the present frame, at the present belief.
    /// @param information  of that belief
    void begin_window(const StateCovariance& information, CalibrationStart calibration);
    /// To integrate from this bias, with gravity and the scale of the IMU's axes as known now.
    Preintegration preintegration_from(const ImuBias& bias) const;
    /// Replaces a worthless belief: the attitude is levelled by the measured specific force, velocity and biases are
    /// forgotten, and position and yaw are roughly kept if they are finite.
    /// @return the initializer's error (belief untouched)
    Status fall_back_to_gravity();
    /// Begins anew at the present frame, from the state predicted by inertial data: attitude, position, velocity and
    /// biases, each with the uncertainty it has reached.
    void restart_in_flight();
    void update_covariance();
    /// Corrections as the prior has them: none, and as uncertain as a good calibration.
    void forget_corrections();
    /// Hands the front-end what the window has found of single cameras.
    void update_corrections();
    /// Integrates anew the inertial factors whose bias has moved too far for their first-order correction.
    void reintegrate();
    Status carry_on(const StereoFrame& frame, Timestamp stamp, Estimate& estimate);
    void act(FrameAction action, const Preintegration& preintegration);
    HealthEvidence evidence(const StereoFrame& frame, bool frame_taken) const;
    void report(const StereoFrame& frame, bool frame_taken, Estimate& estimate);
};

}  // namespace facet
