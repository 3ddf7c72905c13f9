// SPDX-License-Identifier: BSD-2-Clause
// Estimates onto ROS 2 topics, by a thread of its own.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <semaphore>
#include <string>
#include <thread>

#include "drivers/ros2/ros2_node.h"
#include "platform/base/spsc_queue.h"
#include "platform/port/clock.h"
#include "platform/port/odometry_sink.h"

namespace facet {

/// What somebody listens to.
struct Ros2Wishes {
    bool mesh = false;  ///< or planes
    bool landmarks = false;
    bool path = false;
    bool grid = false;
};

/// Where mesh, planes, landmarks, path and grid come from.
class Ros2SceneSource {
public:
    virtual ~Ros2SceneSource() = default;

    /// On the output's thread, some thirty times a second. What is not wished for need not be given from now on.
    /// @param scene  emptied, with the capacities that it had
    /// @return whether there is anything new
    virtual bool take(const Ros2Wishes& wishes, Ros2Scene& scene) = 0;
};

struct Ros2OutputCounters {
    std::atomic<std::uint64_t> poses{0};    ///< published
    std::atomic<std::uint64_t> dropped{0};  ///< estimates lost because the thread or the middleware was behind
    std::atomic<std::uint64_t> lost{0};     ///< estimates held back because the estimator was lost
    std::atomic<std::uint64_t> scenes{0};   ///< meshes, clouds of landmarks, paths and grids published
};

/// send() and report() only put a value into a queue; the thread publishes. Poses of an estimator that is lost are not
/// published, since nothing in nav_msgs/Odometry says so: the diagnostics do, once a second. Queues hold 64 estimates
/// and 16 changes of state: when full, the newest are dropped and counted. Thread-bound, but for the counters. Heap in
/// open() and on its own thread.
class Ros2Output final : public OdometrySink {
public:
    /// Borrowed: node, clock and scene, which must outlive this. @param scene  may be null
    Ros2Output(Ros2Node& node, const Clock& clock, const Ros2OutputNames& names);
    ~Ros2Output() override { close(); }
    Ros2Output(const Ros2Output&) = delete;
    Ros2Output& operator=(const Ros2Output&) = delete;

    /// Before open(). Borrowed until close(); nullptr: poses and diagnostics only.
    void show(Ros2SceneSource* scene) { scene_source_ = scene; }

    /// Starts the thread. @return kIo or kInvalidArgument with the words
    Status open(std::string& problem);
    /// Publishes what waits, and ends the thread.
    void close();

    /// kFull if the queue is; kInvalidArgument as OdometrySink has it.
    Status send(const Odometry& odometry) override;
    void report(const StateChange& change) override;

    /// Such as "ROS 2: /facet/odometry".
    std::string name() const;
    const Ros2OutputCounters& counters() const { return counters_; }

private:
    void work();
    void publish_poses();
    void publish_scene();
    void publish_diagnostics();
    Timestamp to_realtime(Timestamp stamp) const;

    const Clock& clock_;
    Ros2OutputNames names_;
    std::unique_ptr<Ros2Publisher> publisher_;
    Ros2SceneSource* scene_source_ = nullptr;
    Ros2OutputCounters counters_;
    SpscQueue<Odometry, 64> poses_;
    SpscQueue<StateChange, 16> changes_;
    std::counting_semaphore<> wakeup_{0};
    std::atomic<bool> stopping_{false};
    std::thread thread_;
    // Of the thread:
    Ros2Scene scene_;
    Odometry newest_;
    bool any_ = false;
    StateChange state_;
    Timestamp next_scene_;
    Timestamp next_diagnostics_;
};

}  // namespace facet
