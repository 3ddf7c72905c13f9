// SPDX-License-Identifier: BSD-2-Clause
// The state at every inertial sample: that of the newest frame, propagated as samples come.
#pragma once

#include "estimator/api/belief.h"
#include "estimator/imu/imu_buffer.h"
#include "estimator/values/refused_run.h"

namespace facet {

/// Propagates the newest frame's state to each inertial sample, so that consumers have a state at the IMU's rate and
/// without the delay of images. Usage:
///   carrier.configure(config.imu_noise, config.imu_limits, gravity);
///   if (ok(carrier.add_imu(sample)) && carrier.has_state()) use(carrier.stamp(), carrier.state());
///   (void)carrier.correct(estimator.belief());      // after each frame
///   carrier.forget();                               // when the estimate must not be used
/// It has a history of samples of its own and needs nothing of the estimator, so that it may live in another thread: a
/// keyframe that takes its time delays no output. State and covariance are those of Preintegration and
/// propagate_covariance over the samples since the belief, one step a sample. Stamps are those of the samples, which
/// only increase; a correction changes the state at the present stamp, and is seen at the next one.
///
/// If samples go on before the newest one for half a second, their clock has gone back: the history restarts, and
/// there is no state until the next correction.
///
/// Smoothing, if configured: the step that a correction makes is taken back and fades as exp(-t / smoothing_s), in
/// attitude, position and velocity. The covariance stays that of the unsmoothed state.
/// A sample costs one step of integration, a covariance one propagation; a correction a step for each sample since the
/// belief. About 760 kB: a member or static. Thread-bound. No heap.
class StateCarrier {
public:
    /// Starts over. @param smoothing_s  0: corrections are steps
    void configure(const ImuNoise& noise, const ImuLimits& limits, double gravity_m_per_s2, double smoothing_s = 0.0);

    /// Takes the next sample and carries the state on to it.
    /// @param clipped  its axes at their range as read
    /// @return as ImuBuffer::push: a refused sample changes nothing
    Status add_imu(const ImuSample& sample, ImuAxisMask clipped);
    Status add_imu(const ImuSample& sample) { return add_imu(sample, limits_.clipped_axes(sample)); }

    /// Replaces the belief that is carried on.
    /// @return kNotReady if samples do not reach its stamp, kNotFound if they do not reach back to it, kOutOfOrder if
    ///         it is older than the one before (nothing changed)
    Status correct(const Belief& belief);

    /// There is no state until the next correction.
    void forget() { has_state_ = false; }

    bool has_state() const { return has_state_; }
    /// Of the newest sample. Contract for this and the following: has_state().
    Timestamp stamp() const { return carried_; }
    NavState state() const;
    /// Order [theta p v bg ba].
    StateCovariance covariance() const {
        StateCovariance covariance = propagate_covariance(belief_.state, belief_.covariance, since_, noise_);
        add_ripple(imu_, unsmoothed(), covariance);
        return covariance;
    }

private:
    using Step = Eigen::Matrix<double, kBiasGyro, 1>;

    /// Replaces what a belief suspects of the samples after it.
    void replace_readings(const Belief& belief);
    NavState unsmoothed() const { return since_.predict(belief_.state); }

    ImuBuffer imu_;
    ImuLimits limits_;
    RefusedRun refused_;  ///< since the last sample that was taken
    ImuNoise noise_;
    double smoothing_s_ = 0.0;
    bool has_state_ = false;
    Belief belief_;
    Preintegration since_;  ///< from the belief to the newest sample
    Timestamp carried_;
    Step taken_back_ = Step::Zero();  ///< of the steps of corrections, in the state's tangent
};

}  // namespace facet
