// SPDX-License-Identifier: BSD-2-Clause
// Output off the estimator's thread: one thread for the sinks, one for the files.
#pragma once

#include <atomic>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/pipeline/frame_recorder.h"
#include "app/run/estimator_loop.h"
#include "app/run/odometry_stream.h"
#include "app/run/run_event.h"
#include "app/run/sink_news.h"
#include "app/run/stall_watch.h"
#include "platform/linux/linux_wakeup.h"
#include "platform/linux/priority_mutex.h"
#include "platform/port/odometry_sink.h"

namespace facet {

/// What the status shows of the newest frame.
struct FrameStatus {
    std::uint64_t frames = 0;
    Health health;
    Eigen::Vector3d p_W_B = Eigen::Vector3d::Zero();
    double speed_m_per_s = 0.0;
    double total_ms = 0.0;
    std::size_t planes = 0;
    int mesh_faces = 0;
    double latency_median_ms = 0.0;  ///< of the last few seconds
    double latency_p99_ms = 0.0;
    std::vector<std::string> events;  ///< the newest, oldest first
};

struct OutputCounters {
    std::atomic<std::uint64_t> poses_sent{0};      ///< given to all sinks
    std::atomic<std::uint64_t> poses_dropped{0};   ///< estimates and samples lost because the sinks' thread was behind
    std::atomic<std::uint64_t> frames_dropped{0};  ///< because the files' thread was behind
    std::atomic<std::uint64_t> faces_dropped{0};
    std::atomic<std::uint64_t> refused{0};  ///< poses that a sink did not take
};

/// The bodies of two threads. One carries the newest estimate on by inertial samples and sends it, however long a frame
/// keeps the estimator busy or a disk makes the files wait; while the estimator's thread or the inertial sensor gives
/// no sign of life (StallWatch), as DEGRADED, and LOST once that has lasted health.lost_after_s. Queues hold 1024
/// samples, 32 estimates, 64 frames and 16384 faces: when full, the newest are dropped and counted. A file that cannot
/// be written ends the writing, not the run. The sides of the estimator and the IMU use neither heap nor lock.
class OutputThreads final : public LoopOutput {
public:
    /// Borrowed: clock, sinks, recorder, event queues.
    /// @param keep_latencies  newest latencies kept for the account
    OutputThreads(const Clock& clock, const ProgramConfig& config, const VehicleOdometry& odometry,
                  std::vector<OdometrySink*> sinks, FrameRecorder& recorder, std::vector<EventQueue*> events,
                  std::size_t keep_latencies);

    /// On the IMU's thread: every sample, before the estimator's thread can have it.
    void on_sample(const ImuSample& sample);

    // On the estimator's thread:
    void on_estimate(const FrameResult& frame, const Belief& belief, const Eigen::Vector3d& w_B) override;
    void on_frame(const FrameResult& frame, std::span<const DepartedFace> departed) override;
    void on_report(const SyncReport& report) override;
    /// Whenever it has taken what there was.
    void on_beat() { watch_.beat(); }
    /// Nothing more will come, and nothing more is judged.
    void on_end() { watch_.end(); }

    /// The bodies; each returns when it is `stopping` and its queues are empty.
    void send_poses(const std::atomic<bool>& stopping);
    void write_files(const std::atomic<bool>& stopping);

    // On any thread:
    FrameStatus status() const;
    const OutputCounters& counters() const { return counters_; }
    /// A thread without which nothing that is to be used is sent, and that gives no sign of life: the inertial
    /// sensor's, also before its first sample, the estimator's or the sinks'. nullptr if there is none.
    const char* silent_thread() const;
    /// The same of a thread that hangs: one that waits for no sensor, and has been silent for health.lost_after_s.
    const char* hanging_thread() const;
    /// Frames that the estimator has accepted.
    std::uint64_t frames() const { return frames_.load(std::memory_order_relaxed); }

    // After both bodies have returned:
    /// Why files are incomplete; empty if they are complete.
    const std::string& failure() const { return failure_; }
    const std::vector<double>& latencies_ms() const { return latencies_ms_; }
    /// Brings the health of the last estimate to how it ended: as a state that nothing had confirmed for a while.
    void add_end(Health& health) const;

private:
    void send(const Odometry& odometry);
    bool carry_on();
    void watch();
    void end_stall();
    void mark_stalled(TrackingState state);
    void keep_latency(double latency_ms);
    bool write_once();
    bool write_events();
    template <class Function>
    void guarded(Function function);
    void publish(const FrameResult& frame);

    const Clock& clock_;
    OdometryStream stream_;  ///< of the sending thread
    std::vector<OdometrySink*> sinks_;
    FrameRecorder& recorder_;
    std::vector<EventQueue*> events_;
    std::size_t keep_latencies_;
    EventQueue reports_;        ///< of the synchroniser
    EventQueue stall_reports_;  ///< of the sending thread
    StallWatch watch_;          ///< the estimator
    StallWatch readings_;       ///< the inertial sensor
    StallWatch sending_;        ///< the sinks
    double lost_after_s_;
    SpscQueue<ImuSample, 1024> samples_;
    SpscQueue<FrameOutcome, 32> outcomes_;
    SinkNews news_;
    SpscQueue<FrameResult, 64> frame_queue_;
    SpscQueue<DepartedFace, 16384> faces_;
    LinuxWakeup pose_wakeup_;
    LinuxWakeup frame_wakeup_;
    OutputCounters counters_;
    std::atomic<std::uint64_t> frames_{0};
    FrameOutcome outcome_;                   ///< of the sending thread
    std::optional<TrackingState> stalled_;   ///< of the sending thread: as what poses go on without the estimator
    std::uint32_t stall_reason_ = 0;         ///< of the sending thread: why
    Timestamp stalled_at_;                   ///< of the sending thread: the newest frame when it began
    std::optional<Timestamp> unsent_frame_;  ///< of the sending thread: in the estimate, but not yet sent
    FrameResult frame_;                      ///< of the writing thread
    std::vector<DepartedFace> batch_;        ///< of the writing thread
    std::string failure_;
    Timestamp next_flush_;
    std::vector<double> latencies_ms_;
    std::size_t oldest_latency_ = 0;
    mutable PriorityMutex mutex_;  ///< between writer, sender and whoever shows the status; never the estimator
    FrameStatus status_;
    RingBuffer<double, 128> recent_ms_;
};

}  // namespace facet
