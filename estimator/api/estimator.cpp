// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/api/estimator.h"

#include <algorithm>
#include <cmath>

#include "estimator/api/belief.h"
#include "estimator/api/health_monitor.h"
#include "estimator/api/keyframe_snapshot.h"
#include "estimator/api/motion_start.h"
#include "estimator/factors/rest_factor.h"
#include "estimator/frontend/frontend.h"
#include "estimator/imu/imu_buffer.h"
#include "estimator/imu/propagation.h"
#include "estimator/imu/static_init.h"
#include "estimator/imu/stationarity.h"
#include "estimator/window/stage_scope.h"
#include "estimator/window/window.h"

namespace facet {
namespace {

// An inertial factor is integrated anew when its bias has moved this far: then the first-order correction errs.
constexpr double kReintegrateGyro = 2e-3;   // rad/s
constexpr double kReintegrateAccel = 5e-2;  // m/s^2
// A start in flight needs this many stereo matches: they are all that ties the first keyframes together.
constexpr int kRestartStereo = 20;
// Before the first estimate is given out the window may take longer: its first guess may be far off, and it is small.
constexpr double kInitEffort = 4.0;
// After a frame that came too late, up to the next keyframe: shares of the solver's steps and of the features.
constexpr double kLateEffort = 0.5;
constexpr double kLateFeatures = 0.67;
// When a rest ends, a keyframe this old is followed by one at once: inertial data have carried it on for too long.
constexpr double kStaleKeyframe = 0.5;  // s
// After divergence nothing but the direction of gravity and the place is kept, and those roughly.
constexpr double kDivergedTiltSigma = 0.2;      // rad
constexpr double kDivergedVelocitySigma = 2.0;  // m/s
constexpr double kDivergedPositionSigma = 1.0;  // m
constexpr double kDivergedYawSigma = 0.2;       // rad

}  // namespace

struct Estimator::Impl {
    EstimatorConfig config;
    StereoRig rig;
    StageObserver* observer = nullptr;
    ObservationHook* hook = nullptr;
    ImuBuffer imu;
    Frontend frontend;
    FrontendOutput tracks;
    Window window;
    HealthMonitor monitor;
    MotionStart motion_start;
    Belief newest;  ///< at the newest keyframe
    Belief now;     ///< at the newest frame
    ImuSpan span;   ///< samples between them
    bool has_frame = false;
    bool is_coasting = false;  ///< `now` no longer comes from the window: inertial history too short, or lost
    bool wants_reset = false;  ///< asked for by the user
    bool rests = false;        ///< inertial samples: at rest at every frame since the newest keyframe
    bool is_late = false;      ///< a frame took too long: less work up to the next keyframe
    bool is_held = false;      ///< `now` is the newest keyframe's place, because the vehicle stands
    Timestamp last_image;      ///< stamp of the last frame as given
    RigCalibration::Tangent calibration_sigma = RigCalibration::Tangent::Zero();
    std::uint32_t reset_counter = 0;
    WindowSummary summary;
    KeyframeView view;  ///< landmarks at the newest keyframe

    void reset();
    /// Stamp of an image in the IMU's clock.
    Timestamp imu_stamp(Timestamp image) const {
        return image + Duration::from_seconds(window.calibration().time_offset_s);
    }
    KeyframeInput keyframe_input() const;
    Status start(const StereoFrame& frame, Estimate& estimate);
    Status predict(Timestamp stamp, Preintegration& preintegration);
    Status track(const StereoFrame& frame, Timestamp before, bool wants_keyframe);
    void judge_rest(bool image_is_still);
    void hold_still();
    void take_keyframe(const Preintegration& preintegration);
    void second_opinion();
    void begin_window(const StateCovariance& information);
    Status fall_back_to_gravity();
    void restart_in_flight();
    void update_covariance();
    void reintegrate();
    void fill(const StereoFrame& frame, bool frame_taken, Estimate& estimate);
};

void Estimator::Impl::reset() {
    imu.clear(config.imu_noise.rate_hz, config.imu_limits);
    frontend.reset();
    window.configure(config.window, config.calibration, rig, config.imu_noise, config.regularity);
    monitor.configure(config.health);
    motion_start.configure(rig, config.imu_noise, config.window.pixel_sigma_px);
    monitor.reset();
    tracks = {};
    newest = now = {};
    span = {};
    has_frame = is_coasting = wants_reset = rests = is_late = is_held = false;
    calibration_sigma.setZero();
    reset_counter = 0;
    summary = {};
    view.number = 0;
    view.landmarks.clear();
    view.surface.clear();
    view.keyframes.clear();
    view.planes.clear();
}

KeyframeInput Estimator::Impl::keyframe_input() const {
    KeyframeInput input;
    input.stamp = now.stamp;
    input.observations = {tracks.observations.data(), tracks.observations.size()};
    input.rests_since_previous = rests && tracks.is_still;
    ImuSample sample;
    if (ok(imu.interpolate(now.stamp, sample))) {
        input.w_B = sample.w_B - now.state.bias.gyro;
    }
    return input;
}

Status Estimator::Impl::track(const StereoFrame& frame, Timestamp before, bool wants_keyframe) {
    FrameHints hints;
    hints.wants_keyframe = wants_keyframe;
    hints.effort = is_late ? kLateFeatures : 1.0;
    if (has_frame) {
        const StageScope scope(observer, Stage::kPropagation);
        FACET_TRY(imu.rotation_between(before, now.stamp, now.state.bias.gyro, hints.q_Bp_B));
    }
    const StageScope scope(observer, Stage::kTracking);
    hints.landmarks = window.predict_landmarks(now.state);
    FACET_TRY(frontend.process(frame, hints, tracks));
    if (hook != nullptr) {
        hook->edit(frame.stamp, {tracks.observations.data(), tracks.observations.size()});
    }
    return Status::kOk;
}

Status Estimator::Impl::start(const StereoFrame& frame, Estimate& estimate) {
    const Timestamp before = now.stamp;
    now.stamp = imu_stamp(frame.stamp);
    InitialState initial;
    if (!ok(initialize_state(imu, now.stamp, config.initializer, initial))) {
        now.stamp = before;
        fill(frame, true, estimate);  // INIT: not enough data before this frame
        return Status::kOk;
    }
    now.state = initial.state;
    const Status tracked = track(frame, before, true);
    has_frame = true;
    last_image = frame.stamp;
    if (ok(tracked) && tracks.is_keyframe) {
        now.covariance = initial.information().inverse();
        begin_window(initial.information());
        monitor.restart(now.stamp, initial.is_still);
    }
    fill(frame, ok(tracked), estimate);
    return tracked;
}

/// Fills `now` and `span` from the newest keyframe, or from the last frame if that is out of reach.
Status Estimator::Impl::predict(Timestamp stamp, Preintegration& preintegration) {
    const StageScope scope(observer, Stage::kPropagation);
    Status status = Status::kNotFound;
    if (!is_coasting) {
        preintegration.reset(newest.state.bias);
        status = imu.integrate_between(newest.stamp, stamp, config.imu_noise, preintegration, &span);
    }
    const Belief from = ok(status) ? newest : now;
    if (!ok(status)) {
        is_coasting = true;
        preintegration.reset(from.state.bias);
        FACET_TRY(imu.integrate_between(from.stamp, stamp, config.imu_noise, preintegration, &span));
    }
    now.stamp = stamp;
    now.state = preintegration.predict(from.state);
    now.covariance = propagate_covariance(from.state, from.covariance, preintegration, config.imu_noise);
    return Status::kOk;
}

void Estimator::Impl::judge_rest(bool image_is_still) {
    Stationarity stationarity;
    const Status known =
        measure_stationarity(imu, now.stamp, config.imu_noise, now.state.bias, config.stationarity, stationarity);
    rests = rests && image_is_still && ok(known) && stationarity.may_be_at_rest;
}

/// The vehicle stands where it stood at the newest keyframe: that tells more than what inertial data, with the error of its
/// velocity and biases, have carried on since.
void Estimator::Impl::hold_still() {
    const RestSigmas sigmas;
    now.state.q_W_B = newest.state.q_W_B;
    now.state.p_W_B = newest.state.p_W_B;
    now.state.v_W_B.setZero();
    now.covariance = newest.covariance;
    now.covariance.middleRows<3>(kVel).setZero();
    now.covariance.middleCols<3>(kVel).setZero();
    now.covariance.diagonal().segment<3>(kTheta).array() += sigmas.theta_rad * sigmas.theta_rad;
    now.covariance.diagonal().segment<3>(kPos).array() += sigmas.p_m * sigmas.p_m;
    now.covariance.diagonal().segment<3>(kVel).setConstant(sigmas.v_m_per_s * sigmas.v_m_per_s);
}

void Estimator::Impl::take_keyframe(const Preintegration& preintegration) {
    if (!ok(window.add_keyframe(keyframe_input(), preintegration))) {
        return;
    }
    const bool is_starting = monitor.state() == TrackingState::kInit;
    summary = window.optimize(is_starting ? kInitEffort : (is_late ? kLateEffort : 1.0));
    frontend.drop_tracks(window.rejected());
    now.state = window.newest().state;
    reintegrate();
    update_covariance();
    newest = now;
    rests = true;
    {
        const StageScope scope(observer, Stage::kLandmarks);
        fill_keyframe_view(window, tracks, view);
    }
    if (is_starting) {
        motion_start.add_keyframe(now.stamp, keyframe_input().observations, imu);
        second_opinion();
    }
}

/// Begins a window with one keyframe: the present frame, at the present belief, of which this is the information.
void Estimator::Impl::begin_window(const StateCovariance& information) {
    window.start(keyframe_input(), now.state, information);
    newest = now;
    summary = {};
    motion_start.reset();
    motion_start.add_keyframe(now.stamp, keyframe_input().observations, imu);
}

/// While starting in motion: a window that contradicts the closed form begins anew from that.
void Estimator::Impl::second_opinion() {
    NavState better;
    StateCovariance information;
    if (!ok(motion_start.check(now.state, better, information))) {
        return;
    }
    now.state = better;
    now.covariance = information.inverse();
    begin_window(information);
}

void Estimator::Impl::update_covariance() {
    const StageScope scope(observer, Stage::kSolve);
    if (ok(window.newest_covariance(now.covariance))) {
        for (int i = 0; i < kCalibrationDim; ++i) {
            calibration_sigma(i) = window.calibration_sigma(i);
        }
    }
}

/// Replaces a worthless belief: the attitude is levelled by the force that is felt, velocity and biases are forgotten, place
/// and yaw are kept roughly if they are numbers. @return the initializer's refusal (untouched)
Status Estimator::Impl::fall_back_to_gravity() {
    InitialState initial;
    FACET_TRY(initialize_state(imu, now.stamp, config.initializer, initial));
    NavState state = initial.state;
    if (is_finite(now)) {
        const Eigen::Vector3d up_B = initial.state.q_W_B.conjugate() * Eigen::Vector3d::UnitZ();
        const Eigen::Quaterniond turn =
            Eigen::Quaterniond::FromTwoVectors(now.state.q_W_B * up_B, Eigen::Vector3d::UnitZ());
        state.q_W_B = (turn * now.state.q_W_B).normalized();
        state.p_W_B = now.state.p_W_B;
    }
    now.state = state;
    const Eigen::Matrix3d R = state.q_W_B.toRotationMatrix();
    const Eigen::Vector3d theta_W(kDivergedTiltSigma, kDivergedTiltSigma, kDivergedYawSigma);
    StateCovariance& c = now.covariance;
    c.setZero();
    c.block<3, 3>(kTheta, kTheta) = R.transpose() * theta_W.cwiseAbs2().asDiagonal() * R;
    c.diagonal().segment<3>(kPos).setConstant(std::pow(kDivergedPositionSigma, 2));
    c.diagonal().segment<3>(kVel).setConstant(std::pow(kDivergedVelocitySigma, 2));
    c.diagonal().segment<3>(kBiasGyro).setConstant(std::pow(config.initializer.gyro_bias_sigma_rad_per_s, 2));
    c.diagonal().segment<3>(kBiasAccel).setConstant(std::pow(config.initializer.accel_bias_sigma_m_per_s2, 2));
    return Status::kOk;
}

/// Begins anew at the present frame, from what inertial data have carried on: attitude, place, velocity and biases, each
/// as uncertain as it has become.
void Estimator::Impl::restart_in_flight() {
    const bool is_worthless = monitor.has_diverged() || !is_finite(now) || tilt_sigma(now) > kDivergedTiltSigma;
    if (is_worthless && !ok(fall_back_to_gravity())) {
        return;
    }
    // Numbers that rounding could make singular are kept from being so.
    now.covariance = (0.5 * (now.covariance + now.covariance.transpose())).eval();
    now.covariance.diagonal().array() += 1e-10;
    rests = is_coasting = wants_reset = false;
    ++reset_counter;
    begin_window(now.covariance.llt().solve(StateCovariance::Identity()));
    monitor.restart(now.stamp, false);
}

/// Integrates the inertial factors anew whose bias has moved too far for their first-order correction.
void Estimator::Impl::reintegrate() {
    const StageScope scope(observer, Stage::kPropagation);
    const auto& keyframes = window.state().keyframes;
    for (std::size_t k = 1; k < keyframes.size(); ++k) {
        if (!keyframes[k].has_imu_factor) {
            continue;
        }
        const ImuBias& bias = keyframes[k - 1].state.bias;
        const ImuBias& then = keyframes[k].imu_from_previous.preintegration().bias();
        const bool moved =
            (bias.gyro - then.gyro).norm() > kReintegrateGyro || (bias.accel - then.accel).norm() > kReintegrateAccel;
        Preintegration anew(bias);
        if (moved && ok(imu.integrate_between(keyframes[k - 1].stamp, keyframes[k].stamp, config.imu_noise, anew))) {
            // Refused only where the old factor was refused as well, and that one was taken.
            static_cast<void>(window.replace_imu_factor(static_cast<int>(k), anew));
        }
    }
}

void Estimator::Impl::fill(const StereoFrame& frame, bool frame_taken, Estimate& estimate) {
    const bool used = frame_taken && has_frame;
    HealthEvidence e;
    e.stamp = now.stamp;
    e.is_started = !window.empty();
    e.frame_taken = frame_taken;
    e.has_right = !frame.right.empty();
    e.image = used ? tracks.image : ImageState::kUsable;
    e.is_keyframe = used && tracks.is_keyframe;
    e.tracked = used ? static_cast<int>(tracks.observations.size()) : 0;
    e.stereo = used ? tracks.stereo : 0;
    e.newest_landmarks = window.state().keyframes.size() > 1 ? summary.newest_landmarks : e.tracked;
    e.imu = span;
    e.speed_m_per_s = now.state.v_W_B.norm();
    e.velocity_sigma_m_per_s = std::sqrt(now.covariance.diagonal().segment<3>(kVel).maxCoeff());
    e.tilt_sigma_rad = tilt_sigma(now);
    e.gyro_bias_rad_per_s = now.state.bias.gyro.norm();
    e.accel_bias_m_per_s2 = now.state.bias.accel.norm();
    const double variance_px2 = config.window.pixel_sigma_px * config.window.pixel_sigma_px;
    e.vision_chi2 = summary.fit.vision_rows > 0
                        ? summary.fit.vision_squared_error_px2 / (variance_px2 * summary.fit.vision_rows)
                        : 0.0;
    e.solver_failed = summary.solver.solver_failed || summary.marginalization_failed;
    e.is_finite = is_finite(now);
    e.is_late = is_late;
    is_late = is_late && !e.is_keyframe;

    estimate = {};
    estimate.stamp = e.is_started ? now.stamp : frame.stamp;
    estimate.state = now.state;
    estimate.covariance = now.covariance.topLeftCorner<9, 9>();
    estimate.T_B_Bc = window.calibration().T_B_Bc;
    estimate.T_B_Bc_sigma = calibration_sigma.tail<6>();
    Health& health = estimate.health;
    monitor.update(e, health);
    health.is_keyframe = e.is_keyframe;
    health.is_still = used && tracks.is_still && rests;
    health.tracked = used ? tracks.tracked : 0;
    health.detected = used ? tracks.detected : 0;
    health.stereo = e.stereo;
    health.recalled = used ? tracks.recalled : 0;
    health.outliers = used ? tracks.outliers : 0;
    health.keyframes = static_cast<int>(window.state().keyframes.size());
    health.landmarks = summary.fit.active_landmarks;
    health.iterations = e.is_keyframe ? summary.solver.iterations : 0;
    health.mean_vision_chi2 = e.vision_chi2;
    health.pixel_sigma_px = window.problem().noise().sigma_px();
    health.imu_chi2 = summary.imu_squared_error / kStateDim;
    health.time_offset_s = window.calibration().time_offset_s;
    health.time_offset_sigma_s = calibration_sigma(kTimeOffset);
    health.reset_counter = reset_counter;
    const ImuBufferCounters& counters = imu.counters();
    health.imu_gaps = counters.gaps;
    health.imu_dropped = counters.out_of_order + counters.not_finite;
    health.imu_clipped = counters.clipped_gyro + counters.clipped_accel;
}

Estimator::Estimator() : impl_(std::make_unique<Impl>()) {}
Estimator::~Estimator() = default;

Status Estimator::configure(const EstimatorConfig& config, const StereoRig& rig) {
    FACET_TRY(config.validate());
    FACET_TRY(CameraModel::validate(rig.left.intrinsics()));
    FACET_TRY(CameraModel::validate(rig.right.intrinsics()));
    FACET_TRY(impl_->frontend.configure(config.frontend, rig));
    impl_->config = config;
    impl_->rig = rig;
    impl_->reset();
    return Status::kOk;
}

void Estimator::set_observation_hook(ObservationHook* hook) { impl_->hook = hook; }

void Estimator::set_stage_observer(StageObserver* observer) {
    impl_->observer = observer;
    impl_->window.set_stage_observer(observer);
}

void Estimator::request_reset() { impl_->wants_reset = !impl_->window.empty(); }

void Estimator::report_overrun() { impl_->is_late = true; }

void Estimator::set_planes(const PlaneProposals& planes) { impl_->window.set_planes(planes); }

std::span<const MemoryPart> Estimator::memory() {
    static_assert(sizeof(Impl) <= kMemoryBudget / 2, "the other half is for images, mesh and planes");
    static constexpr MemoryPart kParts[] = {{"window", sizeof(Window)},
                                            {"inertial history", sizeof(ImuBuffer)},
                                            {"front-end", sizeof(Frontend) + sizeof(FrontendOutput)},
                                            {"start in motion", sizeof(MotionStart)},
                                            {"landmark view", sizeof(KeyframeView)}};
    return kParts;
}

const KeyframeView& Estimator::keyframe_view() const { return impl_->view; }

const VisionResiduals& Estimator::residuals() const { return impl_->window.residuals(); }

Status Estimator::add_imu(const ImuSample& sample) { return impl_->imu.push(sample); }

Status Estimator::add_frame(const StereoFrame& frame, Estimate& estimate) {
    Impl& s = *impl_;
    const Timestamp stamp = s.imu_stamp(frame.stamp);
    if (s.has_frame && (frame.stamp <= s.last_image || stamp <= s.now.stamp)) {
        return Status::kOutOfOrder;
    }
    if (s.imu.empty() || s.imu.newest() < stamp) {
        return Status::kNotReady;
    }
    if (s.window.empty()) {
        return s.start(frame, estimate);
    }
    const Timestamp before = s.now.stamp;
    Preintegration preintegration;
    FACET_TRY(s.predict(stamp, preintegration));
    const bool lost = s.monitor.state() == TrackingState::kLost && s.config.health.auto_reset;
    const bool must_restart = lost || s.wants_reset || s.is_coasting;
    const bool is_imu_poor = s.span.has_gap || s.span.clipped != 0;
    const bool has_moved_off = s.is_held && !s.rests && (stamp - s.newest.stamp).seconds() > kStaleKeyframe;
    const Status tracked = s.track(frame, before, must_restart || is_imu_poor || has_moved_off);
    s.has_frame = true;
    s.last_image = frame.stamp;
    if (ok(tracked)) {
        s.judge_rest(s.tracks.image == ImageState::kUsable);
        if (s.tracks.is_keyframe && must_restart && s.tracks.stereo >= kRestartStereo) {
            s.restart_in_flight();
        } else if (s.tracks.is_keyframe && !s.is_coasting) {
            s.take_keyframe(preintegration);
            s.is_held = false;
        } else if (s.rests && s.tracks.is_still && !s.is_coasting) {
            s.hold_still();
            s.is_held = true;
        }
    }
    s.fill(frame, ok(tracked), estimate);
    return tracked;
}

}  // namespace facet
