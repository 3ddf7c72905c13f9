// SPDX-License-Identifier: BSD-2-Clause
// Output off the estimator's thread: one thread for the sinks, one for the files.
#pragma once

#include <atomic>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "app/pipeline/frame_recorder.h"
#include "app/pipeline/to_odometry.h"
#include "app/run/estimator_loop.h"
#include "app/run/run_event.h"
#include "app/run/sink_news.h"
#include "estimator/values/imu_noise.h"
#include "platform/linux/linux_wakeup.h"
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
    std::atomic<std::uint64_t> poses_dropped{0};   ///< because the sinks' thread was behind
    std::atomic<std::uint64_t> frames_dropped{0};  ///< because the files' thread was behind
    std::atomic<std::uint64_t> faces_dropped{0};
    std::atomic<std::uint64_t> refused{0};  ///< poses that a sink did not take
};

/// The bodies of two threads. Estimates go to the sinks at once, however long a disc makes the files wait. Queues hold
/// 32 poses, 64 frames and 16384 faces: when full, the newest are dropped and counted. A file that cannot be written
/// ends the writing, not the run. The estimator's side uses neither heap nor lock.
class OutputThreads final : public LoopOutput {
public:
    /// Borrowed: clock, sinks, recorder, event queues.
    /// @param keep_latencies  newest latencies kept for the account
    OutputThreads(const Clock& clock, const ImuNoise& noise, std::vector<OdometrySink*> sinks, FrameRecorder& recorder,
                  std::vector<EventQueue*> events, std::size_t keep_latencies);

    // On the estimator's thread:
    void on_frame(const FrameResult& frame, std::span<const DepartedFace> departed,
                  const Eigen::Vector3d& w_B) override;
    void on_report(const SyncReport& report) override;

    /// The bodies; each returns when it is `stopping` and its queues are empty.
    void send_poses(const std::atomic<bool>& stopping);
    void write_files(const std::atomic<bool>& stopping);

    // On any thread:
    FrameStatus status() const;
    const OutputCounters& counters() const { return counters_; }
    /// Frames that the estimator has accepted.
    std::uint64_t frames() const { return frames_.load(std::memory_order_relaxed); }

    // After both bodies have returned:
    /// Why files are incomplete; empty if they are complete.
    const std::string& failure() const { return failure_; }
    const std::vector<double>& latencies_ms() const { return latencies_ms_; }

private:
    struct Pose {
        Odometry odometry;
        bool is_for_sinks = false;
    };

    void send(const Pose& pose);
    void keep_latency(double latency_ms);
    bool write_once();
    bool write_events();
    template <class Function>
    void guarded(Function function);
    void publish(const FrameResult& frame);

    const Clock& clock_;
    ImuNoise noise_;
    std::vector<OdometrySink*> sinks_;
    FrameRecorder& recorder_;
    std::vector<EventQueue*> events_;
    std::size_t keep_latencies_;
    EventQueue reports_;  ///< of the synchroniser
    SpscQueue<Pose, 32> poses_;
    SinkNews news_;
    SpscQueue<FrameResult, 64> frame_queue_;
    SpscQueue<DepartedFace, 16384> faces_;
    LinuxWakeup pose_wakeup_;
    LinuxWakeup frame_wakeup_;
    OutputCounters counters_;
    std::atomic<std::uint64_t> frames_{0};
    Pose pose_;                        ///< of the sending thread
    FrameResult frame_;                ///< of the writing thread
    std::vector<DepartedFace> batch_;  ///< of the writing thread
    std::string failure_;
    Timestamp next_flush_;
    std::vector<double> latencies_ms_;
    std::size_t oldest_latency_ = 0;
    mutable std::mutex mutex_;  ///< between writer, sender and whoever shows the status; never the estimator
    FrameStatus status_;
    RingBuffer<double, 128> recent_ms_;
};

}  // namespace facet
