// SPDX-License-Identifier: BSD-2-Clause
// The stereo visual-inertial estimator: samples in, estimates out.
#pragma once

#include <memory>
#include <span>

#include "estimator/api/config.h"
#include "estimator/api/estimate.h"
#include "estimator/api/memory_part.h"
#include "estimator/api/observation_hook.h"
#include "estimator/values/keyframe_view.h"
#include "estimator/values/residuals.h"
#include "estimator/values/stage.h"
#include "platform/base/samples.h"

namespace facet {

/// Fixed-lag stereo visual-inertial smoother. Usage:
///   Estimator estimator;
///   FACET_TRY(estimator.configure(config, rig));
///   estimator.add_imu(sample);             // every sample, in order of time
///   estimator.add_frame(frame, estimate);  // every frame, once the samples reach its stamp
/// Thread-bound: one thread at a time. Deterministic: equal inputs give equal bytes. No clock, file, log or exception.
/// Heap only in the constructor and in configure().
class Estimator {
public:
    Estimator();
    ~Estimator();
    Estimator(const Estimator&) = delete;
    Estimator& operator=(const Estimator&) = delete;

    /// Sets everything up; may be called again to start over.
    /// @return kInvalidArgument if config or rig is out of range.
    Status configure(const EstimatorConfig& config, const StereoRig& rig);

    /// Timing hook; nullptr to remove. Not owned.
    void set_stage_observer(StageObserver* observer);

    /// For studies; nullptr to remove. Not owned.
    void set_observation_hook(ObservationHook* hook);

    /// Begins anew at the next frame that allows it: a new window from the present attitude, place, velocity and biases,
    /// the reset counter raised. Without effect before the first start.
    void request_reset();

    /// Buffers one inertial sample.
    /// @return kOutOfOrder or kInvalidArgument (not finite): dropped and counted in Health.
    Status add_imu(const ImuSample& sample);

    /// Estimates the state at the frame's stamp. Before there is enough data to start, and until a start in motion has
    /// found gravity and velocity, Health::state is kInit and the state is not to be used. Without usable images the state
    /// is carried on by inertial data: DEGRADED, after a while LOST. When images are back, landmarks still in the window
    /// are looked for where they should be; once LOST, a new window begins from the state carried on, and
    /// Health::reset_counter rises.
    /// @return kNotReady if inertial samples do not reach the stamp yet: offer the same frame again later;
    ///         kOutOfOrder if the stamp does not increase; kInvalidArgument if the left image has a wrong size (then the
    ///         estimate is still valid: predicted from inertial data, health degraded, unless there is none yet).
    Status add_frame(const StereoFrame& frame, Estimate& estimate);

    /// Tells that a frame was finished too late for whoever waits for it. Up to and including the next keyframe fewer features
    /// are begun and the solver has half its steps; Health shows kReasonOverrun. What a log's replay never calls: its work
    /// is bounded by the configuration alone.
    void report_overrun();

    /// Tells which planes the mesh knows and which landmarks lie on them; holds from the next keyframe on, until told anew.
    /// Without effect in mode S.
    void set_planes(const PlaneProposals& planes);

    /// Bytes of its storage by part, images' buffers excepted: those depend on the rig and are taken in configure().
    static std::span<const MemoryPart> memory();

    /// Landmarks and camera at the newest keyframe; empty before the second one. Valid until the next add_frame.
    const KeyframeView& keyframe_view() const;

    /// Residuals of the keyframes that have left the window since configure().
    const VisionResiduals& residuals() const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace facet
