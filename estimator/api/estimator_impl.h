// SPDX-License-Identifier: BSD-2-Clause
// The estimator's parts and how they work together; private to estimator/api.
#pragma once

#include "estimator/api/belief.h"
#include "estimator/api/estimator.h"
#include "estimator/api/gauge.h"
#include "estimator/api/health_monitor.h"
#include "estimator/api/inertial_doubt.h"
#include "estimator/api/monocular_start.h"
#include "estimator/api/motion_start.h"
#include "estimator/api/phase.h"
#include "estimator/api/refused_run.h"
#include "estimator/api/waiting_keyframe.h"
#include "estimator/frontend/frontend.h"
#include "estimator/imu/delay_search.h"
#include "estimator/imu/imu_buffer.h"
#include "estimator/imu/propagation.h"
#include "estimator/values/camera_corrections.h"
#include "estimator/window/frame_update.h"
#include "estimator/window/local_map.h"
#include "estimator/window/window.h"

namespace facet {

/// A window that began as at rest by inertial samples alone: a glide at constant speed looks the same to them.
enum class RestClaim : std::uint8_t {
    kNone,     ///< it did not, or it has been settled
    kOpen,     ///< images have said nothing yet: INIT
    kSeen,     ///< images agree so far
    kRefuted,  ///< images move: the window begins anew at the next frame that allows it
};

struct Estimator::Impl {
    EstimatorConfig config;
    StereoRig rig;              ///< as given, in the cameras' present roles
    bool is_exchanged = false;  ///< the right camera plays the left one
    double gravity_m_per_s2 = 0.0;
    StageObserver* observer = nullptr;
    ObservationHook* hook = nullptr;
    ImuBuffer imu;
    VibrationLearner vibration;
    Frontend frontend;
    Frontend other_frontend;  ///< for the cameras in exchanged roles
    FrontendOutput tracks;
    Window window;
    LocalMap map;  ///< of the newest keyframe
    FrameUpdate frame_update;
    HealthMonitor monitor;
    MotionStart motion_start;
    MonocularStart monocular_start;
    DelaySearch delay_search;
    bool is_delay_settled = false;
    double found_delay_s = 0.0;  ///< of image stamps, found by that search; the window's is on top of it
    Timestamp window_began;
    /// Velocity is known from before the window began, or by a closed-form solution that agrees with the window.
    bool is_confirmed = true;
    /// A start with one camera whose velocity nothing tells yet: keyframes are collected, the window is not optimized.
    bool awaits_answer = false;
    Belief newest;  ///< at the newest keyframe
    Belief now;     ///< at the newest frame
    ImuSpan span;   ///< samples between them
    Phase phase = Phase::kEmpty;
    RestClaim rest_claim = RestClaim::kNone;
    bool may_stand = false;  ///< begun as in motion, with images that have not moved since
    int hastened = 0;        ///< keyframes that shall still follow each other as fast as at a start
    InertialDoubt doubt;
    bool is_unmatched = false;  ///< the newest keyframe's images do not match each other, or there is one
    bool may_accuse = true;     ///< the newest frame, the inertial readings
    bool is_witnessed = false;  ///< the present doubt, by a keyframe that may
    bool rests = false;         ///< by inertial samples and images: at rest at every frame since the newest keyframe
    bool reset_wanted = false;  ///< requested by the user
    bool is_late = false;       ///< a frame took too long: less work up to the next keyframe
    Timestamp last_image;       ///< stamp of the last frame as given
    Timestamp last_frame;       ///< the same in the IMU's clock
    bool has_frame = false;     ///< there has been a frame
    bool has_primary = false;   ///< there has been an image of the camera in the left one's role
    Timestamp last_primary;     ///< when the last one was
    Timestamp last_pair;        ///< the last frame with both images, or the first frame
    bool has_trusted = false;   ///< there has been an estimate to be used, of this program or of an earlier one
    bool has_given = false;     ///< there has been one of this program since the reset counter last rose
    bool is_renewed = false;    ///< a window has begun anew in flight
    Belief trusted;             ///< the newest one
    Gauge gauge;  ///< what yaw and place of the window are uncertain by, which is added to what is reported
    Gauge drift;  ///< the share of it that a window has found of itself, without what may have slipped
    Eigen::Vector3d leap_W = Eigen::Vector3d::Zero();  ///< by which keyframes have moved the place since it was lost
    /// Residuals that stay high, and what the gauge was before.
    struct Slip {
        bool is_suspected = false;
        bool is_refutable = false;  ///< no keyframe has taken part
        Timestamp keyframe;         ///< with whose map the frames are compared
        Gauge gauge;
    };
    Slip slip;
    bool is_compared = false;  ///< the frame at hand, with the map
    Timestamp compared_with;   ///< the newest keyframe of that map
    /// Of the body since the last frame that the front-end has taken, where `now` was carried on without frames.
    Eigen::Quaterniond q_Bf_B = Eigen::Quaterniond::Identity();
    Duration frame_latency;      ///< inertial samples this young may belong before a frame that is still to come
    RefusedRun refused_samples;  ///< since the last one that was taken
    RefusedRun refused_frames;   ///< likewise
    Timestamp offered;           ///< stamp of the newest frame, taken or not, in the IMU's clock
    bool has_offered = false;
    bool is_bent = false;           ///< the window holds inertial factors that contradict it
    int straight_keyframes = 0;     ///< without such a factor, since
    ImuBias bias_before;            ///< what the biases were before it
    double lost_time_s = 0.0;       ///< that is on no clock, since the window began
    bool is_blind = false;          ///< `now` is being carried on without a frame
    Estimate carried;               ///< the newest without a frame
    bool has_carried = false;       ///< and nobody has asked for it yet
    CameraCorrections corrections;  ///< that the front-end works with
    RigCalibration::Tangent calibration_sigma = RigCalibration::Tangent::Zero();
    std::uint32_t reset_counter = 0;
    WindowSummary summary;
    int map_landmarks = 0;      ///< that the newest frame was compared with
    double frame_chi2 = 0.0;    ///< of that comparison
    KeyframeView view;          ///< landmarks at the newest keyframe
    bool view_is_open = false;  ///< the window has taken a keyframe, and its view is still to be filled
    WaitingKeyframe waiting;
    bool summary_is_new = false;  ///< no estimate has told of it yet

    void reset();
    void configure_starts();
    /// The frame as the cameras' present roles have it, and back.
    StereoFrame in_roles(const StereoFrame& frame) const;
    /// Exchanges the roles if the camera in the left one's is silent, and notes who has given an image.
    StereoFrame choose_camera(const StereoFrame& frame);
    void exchange_cameras();
    /// There is one image, and not just because the other was dropped.
    bool is_alone(const StereoFrame& seen) const;
    /// One of two cameras has been silent for a while.
    bool misses_camera(Timestamp image) const;
    /// A frame without an image to track in.
    Status pass_over(const StereoFrame& frame, Timestamp stamp, Estimate& estimate);
    RigCalibration calibration_as_given() const;
    /// Image stamps plus this are the IMU's time.
    double image_delay_s() const { return found_delay_s + window.calibration().time_offset_s; }
    /// Stamp of an image in the IMU's clock.
    Timestamp imu_stamp(Timestamp image) const { return image + Duration::from_seconds(image_delay_s()); }
    /// Whether the delay of images is in question: it has been corrected far, or the state is not TRACKING.
    bool seeks_delay() const;
    /// Once after a start, when images and gyroscope have turned enough: compares the delay of image stamps with the
    /// window's, and begins anew with it if the window is wrong by more than it may be.
    void settle_delay();
    /// Forgets images, window and doubts, and waits for a start like the first one, whose place, yaw and biases are
    /// those of `trusted`, if there is one.
    void begin_like_first();
    KeyframeInput keyframe_input() const;
    Status start(const StereoFrame& frame, Estimate& estimate);
    /// Fills `now` and `span` from the newest keyframe, or from the last frame if that is out of reach.
    Status predict(Timestamp stamp, Preintegration& preintegration);
    Status track(const StereoFrame& frame, Timestamp before, bool wants_keyframe);
    void judge_rest(bool image_is_still);
    /// What the images say of a start as at rest, as long as the inertial samples say nothing else.
    void judge_rest_claim();
    /// During a start in motion: whether the images have not moved since the window began.
    void judge_shaken_rest();
    /// Once the window, begun as in motion, has seen still images for long enough: it begins anew as at rest, shaken.
    void begin_shaken_rest();
    /// Begins anew at the present frame as in motion: the start as at rest was a glide.
    void restart_in_motion();
    /// The vehicle stands where it stood at the newest keyframe: that is known better than the inertial prediction
    /// since, which has the errors of velocity and biases.
    void hold_still();
    /// Corrects the predicted state by the frame's image, if that sees enough of the map.
    /// @param preintegration  from the newest keyframe to now
    void update_by_image(Preintegration& preintegration);
    /// The state as an image tells it.
    void take_over(const FrameEstimate& updated);
    Status compare_with_map(const Preintegration& preintegration, FrameEstimate& out);
    /// Compares the frame with the map; if it contradicts the inertial readings, settles which of them is right, and
    /// predicts `now` and integrates anew. @return kNotFound if there is nothing to compare with
    Status examine_image(Preintegration& preintegration, FrameEstimate& out);
    InertialDoubt::Limits doubt_limits() const {
        return {config.health.high_vision_chi2, config.health.wrong_vision_chi2};
    }
    /// @param usual  the frame at hand with the readings as they are
    bool calls_for_doubt(const FrameEstimate& usual) const;
    void doubt_readings(Preintegration& preintegration, FrameEstimate& out);
    /// While readings are doubted: replaces those up to the frame that comes. @param stamp  of it
    void replace_doubted(Timestamp stamp);
    /// Whether the frame may accuse the inertial readings: an image of another camera shows a motion, too. The images
    /// of a pair tell by matching each other, and so must those that the map is of. One camera accuses nobody: the
    /// scale of its map is the inertial samples' own.
    void judge_witness();
    /// Readings that no keyframe may accuse are trusted again. Without images they are all there is: they are shown, as
    /// uncertain as they were found, unless they hang.
    void drop_doubt_without_witness(Preintegration& preintegration);
    /// After a keyframe.
    void follow_doubt();
    /// After a keyframe, `newest` still being the one before: a window that contradictory readings have bent, biases
    /// and tilt alike, begins anew once they are over. While readings are in doubt nothing is judged.
    void judge_bend();
    /// What happened in the last dt_s seconds may not have happened: residuals are beyond what errors explain. Adds the
    /// way flown and the angle turned about the vertical to the standard deviations of place and yaw.
    void widen_gauge(double dt_s);
    /// Widens the gauge while residuals are high. If the next frame whose are not agrees with the map that the odd ones
    /// were compared with, nothing has slipped but they, and the gauge is what it was. @return whether it has changed
    bool judge_slip(double dt_s, bool are_residuals_high);
    /// Time has passed that is on no clock, and the motion in it is unknown: the window begins anew.
    void allow_for_lost_time(double lost_s);
    /// The inertial samples that are refused come from a clock, and frames come from the same one.
    bool is_on_new_clock() const;
    /// Makes place and yaw of `trusted` as uncertain as a flight of this time may make them.
    void widen_trusted(double lost_s);
    /// Corrects the state that a start has found by the biases of `trusted`, as two Gaussians are fused.
    void fuse_trusted_bias();
    /// Forgets all samples and waits for a start like the first one, from where the last estimate that was to be used
    /// has been, give or take what the vehicle may have done since.
    void begin_on_new_clock();
    /// Adds what is not known of `now` beyond what its window tells, when that ends.
    void own_up();
    /// After an outage that the window has bridged: adds a share of the way by which images have corrected the place.
    void own_up_to_leap();
    /// @param guess  where the optimization begins; nullptr: where inertial samples lead
    void take_keyframe(const Preintegration& preintegration, const NavState* guess);
    /// Share of the solver's steps at a keyframe.
    double effort() const;
    /// Puts a keyframe into the window, optimizes it, and takes from it what later frames need. `now` and `span` are
    /// the keyframe's, as predicted; `now` becomes the window's. @return false if the window refuses it
    bool enter_window(const KeyframeInput& input, const Preintegration& preintegration, double effort);
    /// Whether the keyframe at hand may wait: all is well, and the image tells the state meanwhile.
    /// @param before  the phase before it
    bool may_wait(Phase before) const;
    /// The keyframe at hand gets its turn later.
    /// @param seen   the state by its image, which is given out
    /// @param guess  as in take_keyframe()
    void let_wait(const Preintegration& preintegration, const FrameEstimate& seen, const NavState* guess);
    bool waits_at_newest_frame() const { return waiting.is_set && waiting.predicted.stamp == now.stamp; }
    /// The turn of a keyframe that waits, if there is one: `newest` is that keyframe then. `now` stays with the newest
    /// frame, whose estimate has been or will be told from what was known without it.
    void take_waiting();
    /// The same where the frame at hand must know of it: predicts `now` anew.
    void take_waiting(Preintegration& preintegration);
    /// What no estimate waits for: a waiting keyframe's turn, the view with its surface points, and what close_view()
    /// does.
    void finish_frame();
    void complete_view();
    void fill_view(const FrontendOutput& seen);
    /// Hands on what the last keyframe has found of the cameras, for the frames after it.
    void close_view();
    /// During a start in motion: if the window contradicts the closed-form solution, it begins anew from that solution.
    void second_opinion();
    /// Gives a belief found without regard to the past its place and yaw: those of `before` with their uncertainty, or,
    /// if no estimate has been used yet, the origin.
    void keep_place(const Belief& before);
    /// Moves the uncertainty of place and yaw from `now` to the gauge: before a window begins at `now`.
    void fix_gauge();
    /// Of `now`, order [theta p v], place and yaw with the gauge's uncertainty.
    Eigen::Matrix<double, 9, 9> reported_covariance() const;
    /// A keyframe while a start with one camera awaits its answer.
    void collect_alone();
    /// Begins a window with one keyframe, the present frame, at the present belief.
    /// @param information  of that belief
    void begin_window(const StateCovariance& information, CalibrationStart calibration);
    /// Begins a window at a belief found without regard to the past, which was `before`, and which gives place and yaw.
    void begin_window_in_place_of(const Belief& before);
    /// What a window that begins after a start gone astray holds of the calibration: what an estimate that was to be
    /// used has found.
    CalibrationStart calibration_start() const {
        return has_trusted ? CalibrationStart::kAsKnown : CalibrationStart::kAsGiven;
    }
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
    /// Learns from the newest inertial factor how much of the vibration accumulates.
    void learn_vibration();
    /// Corrections as the prior has them: none, and as uncertain as a good calibration.
    void forget_corrections();
    /// Hands the front-end what the window has found of single cameras.
    void update_corrections();
    /// Integrates anew the inertial factors whose bias has moved too far for their first-order correction.
    void reintegrate();
    Status carry_on(const StereoFrame& frame, Timestamp stamp, Estimate& estimate);
    /// Rotation since the last frame of the front-end, up to `now`; the front-end begins anew where it is unknown.
    Eigen::Quaterniond turn_since_frame(Timestamp before);
    /// After each inertial sample: if no frame has come for a while, or the inertial history is about to lose what
    /// follows `now`, carries `now` on.
    void carry_without_frames();
    void carry_to(Timestamp stamp);
    /// A frame came too late for the state carried on without it: from now on that waits longer.
    void expect_late_frames(Timestamp image, Timestamp stamp);
    /// `now` stays where `before` is: the vehicle stood when the images went, and the IMU has shown no motion since.
    void stand_blind(const Belief& before);
    /// A place and a yaw to begin anew from when the state itself is worthless.
    Belief salvage() const;
    void act(FrameAction action, Preintegration& preintegration);
    /// Announces that place and yaw may have jumped, if anybody has been given an estimate to compare with.
    void count_reset() {
        reset_counter += has_given ? 1U : 0U;
        has_given = false;
    }
    /// This program has not given an estimate to be used.
    bool is_first_start() const { return !has_given && reset_counter == 0; }
    HealthEvidence evidence(const StereoFrame& frame, bool frame_taken) const;
    void report(const StereoFrame& frame, bool frame_taken, Estimate& estimate);
};

}  // namespace facet
