// SPDX-License-Identifier: BSD-2-Clause
// A flight: how samples and frames pass through front-end, window and the parts that judge them.
#pragma once

#include <span>

#include "estimator/api/config.h"
#include "estimator/api/estimate.h"
#include "estimator/api/kept_state.h"
#include "estimator/api/memory_part.h"
#include "estimator/api/observation_hook.h"
#include "estimator/flight/camera_roles.h"
#include "estimator/flight/delay_correction.h"
#include "estimator/flight/flight_state.h"
#include "estimator/flight/health_monitor.h"
#include "estimator/flight/motion_start.h"
#include "estimator/flight/range_readings.h"
#include "estimator/flight/waiting_keyframe.h"
#include "estimator/frontend/frontend.h"
#include "estimator/imu/vibration.h"
#include "estimator/values/keyframe_view.h"
#include "estimator/values/residuals.h"
#include "estimator/values/stage.h"
#include "estimator/window/frame_update.h"
#include "estimator/window/local_map.h"

namespace facet {

/// What Estimator does, behind its interface (estimator/api/estimator.h), which documents the public functions. Some
/// 33 MB, allocated once. Thread-bound. Heap in configure() only.
///
/// Parts decide, each from what it is given: phase (what to do with a frame), StartProgress, RestDetector,
/// InertialFault, StereoEvidence, GaugeTracker, ClockWatch, EmitterWatch, CameraRoles, DelayCorrection,
/// HealthMonitor. This class asks them in order, and acts:
///   flight.cpp           samples and frames in, in order; prediction and tracking
///   flight_start.cpp     the first window, and what tests it
///   flight_restart.cpp   a window restarts
///   flight_faults.cpp    a frame is compared with the map; readings that contradict it
///   flight_keyframe.cpp  a keyframe's turn in the window, at once or after the next frame
///   flight_upkeep.cpp    what is taken from the window afterwards
///   flight_blind.cpp     without frames, with other cameras
///   flight_report.cpp    what is reported
class FlightEstimator {
public:
    Status configure(const EstimatorConfig& config, const StereoRig& rig);
    Status set_masks(const ImageView& left, const ImageView& right);
    void set_stage_observer(StageObserver* observer);
    void set_observation_hook(ObservationHook* hook) { hook_ = hook; }
    void request_reset();
    void report_overrun() { s_.is_late = true; }
    void set_planes(const PlaneProposals& planes) { window_.set_planes(planes); }
    Status resume(const KeptState& kept, double elapsed_s);

    Status add_imu(const ImuSample& sample, ImuAxisMask clipped);
    Status add_range(const RangeSample& sample);
    Status add_frame(const StereoFrame& frame, Estimate& estimate);
    Status take_carried(Estimate& estimate);
    void finish_frame();

    const EstimatorConfig& config() const { return config_; }
    const Belief& belief() const { return s_.now; }
    /// Whether the newest frame is a keyframe whose turn comes after the next one.
    bool waits_at_newest_frame() const { return waiting_.is_set && waiting_.predicted.stamp == s_.now.stamp; }
    const KeyframeView& keyframe_view() const { return view_; }
    const VisionResiduals& residuals() const { return window_.residuals(); }
    KeptState keep();
    CalibrationEstimate calibration();
    static std::span<const MemoryPart> memory();

private:
    /// What came of a frame before its estimate is reported.
    enum class FrameUse : std::uint8_t {
        kTracked,
        kRefused,  ///< the front-end could not work on it
        kLeftOut,  ///< not looked at: it shows an emitter's dots
        kMissing,  ///< carried on between frames that do not come
    };

    // flight.cpp
    /// A frame that is older than what is known. @return kOutOfOrder then
    Status check_order(Timestamp image, Timestamp stamp);
    Status carry_on(const StereoFrame& frame, Timestamp stamp, Estimate& estimate);
    PredictionEvidence prediction_evidence(const StereoFrame& frame) const;
    Status track(const StereoFrame& frame, Timestamp before, bool wants_keyframe);
    void act(FrameAction action, Preintegration& preintegration);
    /// Fills `now` and `span` from the newest keyframe, or from the last frame if that is out of reach.
    Status predict(Timestamp stamp, Preintegration& preintegration);
    /// To integrate from this bias, with gravity and the scale of the IMU's axes as known now.
    Preintegration preintegration_from(const ImuBias& bias) const;
    /// Image stamps plus this are the IMU's time.
    double image_delay_s() const { return delay_.found_s() + window_.calibration().time_offset_s; }
    Timestamp imu_stamp(Timestamp image) const { return image + Duration::from_seconds(image_delay_s()); }
    /// The window has not seen it: before the first estimate, or while the vehicle has stood ever since.
    bool is_delay_as_given() const;
    /// That, or the first estimate has only just been given.
    bool is_delay_new() const;
    bool seeks_delay() const;
    /// The search may begin any time, and shall have turns then.
    bool may_seek_delay() const;
    /// Compares the turns of images and gyroscope, the frame at hand included. @param image  its stamp
    void examine_delay(Timestamp image);
    /// Restarts if the last frame has shown that the delay is wrong.
    void correct_delay();

    /// Images belong to a time later by off_s than was believed, and with them the state that they have shown: the next
    /// keyframe begins a window there, at a state as uncertain as the motion in that time has made it.
    void move_images(double off_s);

    // flight_start.cpp
    Status start(const StereoFrame& frame, Estimate& estimate);
    void configure_starts();
    StillnessEvidence stillness() const;
    /// What image and samples say of rest, and of a start as at rest.
    void judge_rest();
    /// A keyframe in INIT: tests the window against the start in motion, or a rest.
    void continue_start(const KeyframeInput& input);
    /// If the window contradicts the start in motion, it restarts from that.
    void check_start();
    /// A keyframe while a start with one camera awaits its answer.
    void collect_alone();
    /// The window, begun as in motion, has seen still images for long enough: it restarts as at rest, shaken.
    void begin_shaken_rest();

    // flight_restart.cpp
    /// Begins a window with one keyframe, the present frame, at the present belief. @param information  of that belief
    void begin_window(const StateCovariance& information, CalibrationStart calibration);
    /// The same at a belief found without regard to the past, which was `before`, and which gives position and yaw.
    void begin_window_in_place_of(const Belief& before);
    /// The same at this state, found without regard to `now`, which gives position and yaw.
    void begin_window_at(const NavState& state, const StateCovariance& covariance);
    /// Moves the uncertainty of position and yaw from `now` to the gauge: before a window begins at `now`.
    void fix_gauge();
    /// What a window that begins after a start gone astray holds of the calibration: what an estimate that was to be
    /// used has found.
    CalibrationStart calibration_start() const {
        return s_.trusted ? CalibrationStart::kAsKnown : CalibrationStart::kAsGiven;
    }
    /// Restarts at the present frame as in motion: the start as at rest was a glide.
    void restart_in_motion();
    /// Restarts at the present frame, from the state predicted by inertial data: attitude, position, velocity and
    /// biases, each with the uncertainty it has reached.
    void restart_in_flight();
    /// Adds to the covariance what the window does not know of `now`, when that ends.
    void inflate_covariance();
    /// Replaces a worthless belief by one that knows gravity, and position and yaw roughly.
    /// @return the initializer's error (belief untouched)
    Status fall_back_to_gravity();
    /// The state is carried on by inertial samples alone until the next keyframe, which begins a window.
    void leave_window();
    /// Forgets images, window and suspicions, and waits for a start like the first one, whose place, yaw and biases are
    /// those of `trusted`, if there is one. @param lost_s  time of which nothing is known
    void begin_like_first(double lost_s);
    /// Forgets all samples as well: their clock has been replaced.
    void begin_on_new_clock();

    // flight_faults.cpp
    Status compare_with_map(const Preintegration& preintegration, FrameEstimate& out);
    /// Corrects the predicted state by the frame's image, if that sees enough of the map.
    /// @param preintegration  from the newest keyframe to now
    void update_by_image(Preintegration& preintegration);
    /// The state as an image tells it.
    void take_over(const FrameEstimate& updated);
    /// Compares the frame with the map; if it contradicts the inertial readings, settles which of them is right, and
    /// predicts `now` and integrates again. @return kNotFound if there is nothing to compare with
    Status examine_image(Preintegration& preintegration, FrameEstimate& out);
    InertialFault::Limits fault_limits() const {
        return {config_.health.high_vision_chi2, HealthConfig::kWrongVisionChi2};
    }
    /// @param usual  the frame at hand with the readings as they are
    bool suggests_fault(const FrameEstimate& usual) const;
    void isolate_fault(Preintegration& preintegration, FrameEstimate& out);
    /// Images are dots that move with the vehicle: they are filtered from the next frame on, which begins a window. A
    /// suspicion of the inertial readings was their work, and what it made of the state is undone.
    /// @param preintegration  as in examine_image()
    void take_out_dots(Preintegration& preintegration);
    /// While readings are suspected: replaces those up to the frame that comes. @param stamp  of it
    void replace_readings(Timestamp stamp);
    /// Readings that no keyframe may contradict are used again. Without images they are all there is: they are
    /// shown, as uncertain as they were found, unless they hang.
    void drop_unsupported_fault(Preintegration& preintegration);
    /// After a keyframe: may end the suspicion.
    void follow_fault();

    // flight_keyframe.cpp
    KeyframeInput keyframe_input() const;
    /// A keyframe, at once or, if all is well, after the next frame.
    /// @param preintegration  from the newest keyframe to now @param before  the phase before it
    void add_keyframe(Preintegration& preintegration, Phase before);
    /// @param guess  where the optimization begins; nullptr: where inertial samples lead
    void take_keyframe(const Preintegration& preintegration, const NavState* guess);
    /// Puts a keyframe into the window, optimizes it, and takes from it what later frames need. `now` and `span` are
    /// the keyframe's, as predicted; `now` becomes the window's. @return false if the window refuses it
    bool enter_window(const KeyframeInput& input, const Preintegration& preintegration, double effort);
    /// Share of the solver's steps at a keyframe.
    double effort() const;
    /// Whether the keyframe at hand may wait: all is well, and the image gives the state meanwhile.
    bool may_wait(Phase before) const;
    /// The keyframe at hand gets its turn later. @param seen  the state by its image, which is given out
    void let_wait(const Preintegration& preintegration, const FrameEstimate& seen, const NavState* guess);
    /// The turn of a keyframe that waits, if there is one: `newest` is that keyframe then. `now` stays with the newest
    /// frame, whose estimate has been or will be reported from what was known without it.
    void take_waiting();
    /// The same where the frame at hand must know of it: predicts `now` again.
    void take_waiting(Preintegration& preintegration);

    // flight_upkeep.cpp
    /// What no estimate waits for: the view with its surface points, and what close_view() does.
    void complete_view();
    void fill_view(const FrontendOutput& seen);
    /// Hands on what the last keyframe has found of the cameras, for the frames after it.
    void close_view();
    void update_covariance();
    /// Learns from the newest inertial factor how much of the vibration accumulates.
    void learn_vibration();
    /// Corrections as the prior has them: none, and as uncertain as a good calibration.
    void forget_corrections();
    /// Hands the front-end what the window has found of single cameras.
    void update_corrections();
    /// Integrates again the inertial factors whose bias has moved too far for their first-order correction.
    void reintegrate();

    // flight_blind.cpp
    void exchange_cameras();
    /// A frame without an image to track in.
    Status pass_over(const StereoFrame& frame, Timestamp stamp, FrameUse use, Estimate& estimate);
    /// Rotation since the last frame of the front-end, up to `now`; the front-end restarts where it is unknown.
    Eigen::Quaterniond turn_since_frame(Timestamp before);
    /// After each inertial sample: if no frame has come for a while, or the inertial history is about to lose what
    /// follows `now`, carries `now` on.
    void carry_without_frames();
    Status carry_to(Timestamp stamp, FrameUse use, Estimate& estimate);
    void update_rest(bool images_rest);

    // flight_report.cpp
    HealthEvidence evidence(const StereoFrame& frame, FrameUse use) const;
    void report(const StereoFrame& frame, FrameUse use, Estimate& estimate);
    /// Of `now`, order [theta p v], position and yaw with the gauge's uncertainty.
    Eigen::Matrix<double, 9, 9> reported_covariance() const;

    EstimatorConfig config_;
    double gravity_m_per_s2_ = 0.0;
    StageObserver* observer_ = nullptr;
    ObservationHook* hook_ = nullptr;
    CameraRoles cameras_;
    ImuBuffer imu_;
    RangeReadings ranges_;
    VibrationLearner vibration_;
    Frontend frontend_;
    Frontend other_frontend_;  ///< for the cameras in exchanged roles
    FrontendOutput tracks_;
    Window window_;
    LocalMap map_;  ///< of the newest keyframe
    FrameUpdate frame_update_;
    HealthMonitor monitor_;
    MotionStart motion_start_;
    DelayCorrection delay_;
    WaitingKeyframe waiting_;
    KeyframeView view_;  ///< landmarks at the newest keyframe
    FlightState s_;
};

}  // namespace facet
