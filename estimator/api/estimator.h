// SPDX-License-Identifier: BSD-2-Clause
// The stereo visual-inertial estimator: samples in, estimates out.
#pragma once

#include <memory>
#include <span>

#include "estimator/api/belief.h"
#include "estimator/api/config.h"
#include "estimator/api/estimate.h"
#include "estimator/api/kept_state.h"
#include "estimator/api/memory_part.h"
#include "estimator/api/observation_hook.h"
#include "estimator/values/keyframe_view.h"
#include "estimator/values/residuals.h"
#include "estimator/values/stage.h"
#include "platform/base/range_sample.h"
#include "platform/base/samples.h"

namespace facet {

class FlightEstimator;

/// Fixed-lag stereo visual-inertial smoother. Usage:
///   Estimator estimator;
///   FACET_TRY(estimator.configure(config, rig));
///   estimator.add_imu(sample);             // every sample, in order of time
///   estimator.add_frame(frame, estimate);  // every frame, once the samples reach its stamp
///   estimator.finish_frame();              // when the estimate is on its way
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

    /// Masks of the vehicle in each camera's view: no features are taken where a mask is black (0). An empty view masks
    /// nothing. Call it after configure(), which clears masks.
    /// @return kInvalidArgument if a size is not its camera's.
    Status set_masks(const ImageView& left, const ImageView& right);

    /// Timing hook; nullptr to remove. Not owned.
    void set_stage_observer(StageObserver* observer);

    /// Hook for studies; nullptr to remove. Not owned.
    void set_observation_hook(ObservationHook* hook);

    /// Restarts at the next frame that allows it: a new window starts from the present attitude, position, velocity
    /// and biases, and the reset counter is raised. Has no effect before the first start.
    void request_reset();

    /// Buffers one inertial sample. If no frame has come for half a second, propagates the estimate ten times a second,
    /// up to 0.2 s before the newest sample; a frame that comes later than that is refused once, then waited for (up to
    /// 1 s).
    /// @param clipped  of a sample that was corrected for scale and misalignment: the axes at their range as read
    ///                 (ImuLimits::clipped_axes); else the sample's own
    /// @return kOutOfOrder or kInvalidArgument (not finite): dropped and counted in Health.
    Status add_imu(const ImuSample& sample, ImuAxisMask clipped);
    Status add_imu(const ImuSample& sample);

    /// Gives one reading of a range finder that looks down, with RangeConfig::enabled; else it is ignored. A keyframe
    /// uses the newest reading before it, if that is no older than 0.1 s: changes of height over level ground are held
    /// by it. Edges begin a new level; over a ramp, and once readings stop, Health has kReasonRange.
    /// @return kOutOfOrder if its stamp does not increase, kInvalidArgument if it is not finite (dropped)
    Status add_range(const RangeSample& sample);

    /// The newest estimate that add_imu() has propagated without frames: DEGRADED with kReasonNoImages at first, LOST
    /// after a while, with growing covariance. A vehicle at rest when the images stopped, whose IMU has shown no motion
    /// since, keeps its position. Call it after each sample.
    /// @return kNotReady if there is no new one since the last call (estimate untouched).
    Status take_carried(Estimate& estimate);

    /// Estimates the state at the frame's stamp. Until there is enough data to start, and until a start in motion has
    /// found gravity and velocity, Health::state is kInit and the state must not be used. Without usable images the
    /// state is predicted from inertial data: DEGRADED at first, LOST after a while. When images return, landmarks
    /// still in the window are searched for where they are predicted; once LOST, a new window begins from the predicted
    /// state, and Health::reset_counter rises.
    /// One image is enough, the left or the right one, at any time and from the first frame on; the other one's view is
    /// then empty. When the left camera has been silent for 0.3 s, the right one takes its role in a new window.
    /// @return kNotReady if inertial samples do not reach the stamp yet: offer the same frame again later;
    ///         kOutOfOrder if the stamp does not increase; kInvalidArgument if the left image has a wrong size (the
    ///         estimate, if there is one yet, is then still valid: predicted from inertial data, health degraded).
    Status add_frame(const StereoFrame& frame, Estimate& estimate);

    /// Reports that the last frame was finished too late for its consumer. Up to and including the next keyframe, fewer
    /// features are started and the solver is limited to half its steps; Health shows kReasonOverrun. Not called when a
    /// log is replayed: there the work is bounded by the configuration alone.
    void report_overrun();

    /// Passes the planes that the mesh has found, with the landmarks on them. They are used from the next keyframe on,
    /// until the next call. Has no effect in mode S.
    void set_planes(const PlaneProposals& planes);

    /// Bytes of the estimator's own storage, by part, without the image buffers: those depend on the rig and are
    /// allocated in configure().
    static std::span<const MemoryPart> memory();

    /// State at the newest frame with its full covariance: what a StateCarrier propagates. Only while
    /// Health::state is kTracking or kDegraded.
    const Belief& belief() const;

    /// What a restarted program may continue from (resume()); only while Health::state is kTracking or kDegraded. Takes
    /// about a millisecond.
    KeptState keep() const;

    /// Continues from the state that an earlier program has kept, instead of from the origin. The start, at rest or in
    /// motion, is the usual one, but position and yaw are those kept, with uncertainty for the time since, biases and
    /// calibration those kept with twice their standard deviations. Health::reset_counter begins at zero: the caller
    /// announces that poses are not continuous with the earlier program's. Call it after configure(), before the first
    /// frame.
    /// @param elapsed_s  since it was kept, >= 0
    /// @return kInvalidArgument if something is not finite, a standard deviation of the state is not positive, or one
    ///         of an estimated calibration parameter, unless all are zero: nothing is known of it (nothing changed)
    Status resume(const KeptState& kept, double elapsed_s);

    /// The work of the last frame that no estimate waits for. After a keyframe: its surface points, as much work as a
    /// tracked frame. Then its optimization in the window and its keyframe_view(), at once or, with
    /// WindowConfig::spread_keyframes in regular flight, after the frame that follows it, so that no frame takes the
    /// time of both. Call it after each add_frame, before the next one. Without it add_frame does the necessary work
    /// later, with equal estimates, but there is no view.
    void finish_frame();

    /// Whether the last frame is a keyframe that enters the window after the next frame. Its estimate is that of its
    /// image, like a tracked frame's.
    bool keyframe_waits() const;

    /// Landmarks, surface points and camera at a keyframe, which it names by its stamp: the newest one that the window
    /// has taken, where finish_frame() was called after it; empty before the second keyframe. Valid until the next
    /// add_frame, and after it as long as its number is the same.
    const KeyframeView& keyframe_view() const;

    /// The calibration as it is estimated now. Takes about a millisecond: not for every frame.
    CalibrationEstimate calibration() const;

    /// Residuals of the keyframes that have left the window since configure().
    const VisionResiduals& residuals() const;

private:
    std::unique_ptr<FlightEstimator> flight_;
};

}  // namespace facet
