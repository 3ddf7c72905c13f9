// SPDX-License-Identifier: BSD-2-Clause
// The work of the estimator thread: moves samples from their queues through the synchroniser into the pipeline.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <span>

#include "app/pipeline/frame_pipeline.h"
#include "app/run/intake.h"
#include "platform/base/ring_buffer.h"
#include "platform/port/clock.h"

namespace facet {

/// Where the loop's results go. Called on its thread; must not block.
class LoopOutput {
public:
    virtual ~LoopOutput() = default;
    /// The estimate is ready; mesh, planes and ranges are still to come.
    /// @param belief  see Estimator
    /// @param w_B     the newest angular rate given to the estimator, its bias still in it (rad/s)
    virtual void on_estimate(const FrameResult& frame, const Belief& belief, const Eigen::Vector3d& w_B) = 0;
    /// The same frame, finished.
    /// @param departed  faces that left the horizon at this frame
    virtual void on_frame(const FrameResult& frame, std::span<const DepartedFace> departed) = 0;
    virtual void on_report(const SyncReport& report) = 0;
};

struct EstimatorLoopOptions : IntakeOptions {
    Duration max_hold = Duration::from_seconds(0.5);  ///< inertial samples older than this do not wait for a frame
};

/// What the loop has dropped or found; may be read from any thread.
struct LoopCounters {
    std::atomic<std::uint64_t> paired{0};    ///< frames that came out of the synchroniser
    std::atomic<std::uint64_t> late{0};      ///< of these, dropped because a newer one was ready
    std::atomic<std::uint64_t> used{0};      ///< accepted by the estimator
    std::atomic<std::uint64_t> refused{0};   ///< refused by it
    std::atomic<std::uint64_t> overruns{0};  ///< frames that took longer than the cameras' period
    SharedFindings findings{};
};

/// Of several frames that are ready only the newest is used. Inertial samples are held back and given to the estimator
/// right before the frame that needs them, up to the first one at or after its stamp, with the time offset that the
/// estimator has found: whatever the threads' timing, the estimator sees the same sequence, which is that of a replay,
/// as long as frames come within max_hold and none is late. Thread-bound, except counters(). No heap after
/// construction.
class EstimatorLoop {
public:
    static constexpr std::size_t kHeld = 4096;

    /// Everything is borrowed.
    EstimatorLoop(const EstimatorLoopOptions& options, const Clock& clock, FramePipeline& pipeline, RunQueues& queues,
                  LoopOutput& output);

    /// Shows the tap, which is borrowed, everything from now on. To be called before the first step.
    void show(SampleTap* tap) { intake_.show(tap); }
    /// Takes what is in the queues and processes it. @return whether there was anything to do
    bool step();
    /// Gives up the frame that waits for inertial samples, so that its camera has the image back: no more will come. It
    /// counts as late. @return whether there was one
    bool drop_frame();
    /// For when no more samples will come: uses the frames that inertial samples reach.
    void finish();

    const LoopCounters& counters() const { return counters_; }

private:
    void hold(const ImuSample& sample);
    bool give_frames();
    bool try_frame();
    void feed_next();
    void feed_until(Timestamp stamp);
    void pass_on_reports();

    EstimatorLoopOptions options_;
    const Clock& clock_;
    FramePipeline& pipeline_;
    Intake intake_;
    LoopOutput& output_;
    LoopCounters counters_;
    RingBuffer<ImuSample, kHeld> held_;
    std::optional<SyncedFrame> pending_;  ///< ready, but the estimator may need more inertial samples
    ImuSample newest_;                    ///< of those taken from the queue
    bool any_fed_ = false;
    ImuSample fed_;  ///< the newest that the estimator has
    FrameResult result_;
};

}  // namespace facet
