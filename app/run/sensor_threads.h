// SPDX-License-Identifier: BSD-2-Clause
// The threads of a vehicle's sensors, from their devices into the queues.
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "app/config/vehicle.h"
#include "app/output/live_account.h"
#include "app/run/intake.h"
#include "app/run/run_queues.h"
#include "app/run/source_thread.h"
#include "platform/linux/linux_worker.h"
#include "platform/port/imu_source.h"
#include "platform/port/range_queue.h"

namespace facet {

/// The sensors of a run, borrowed.
struct RunSources {
    CameraSource* left = nullptr;      ///< or the camera whose images hold both views side by side
    CameraSource* right = nullptr;     ///< nullptr if side by side, or if there is one camera
    TriggerSource* trigger = nullptr;  ///< nullptr if there is none
    ImuSource* imu = nullptr;
    RangeQueue* ranges = nullptr;  ///< that a flight controller's link fills; nullptr if there is no range finder
};

/// Starts threads and collects what the system refuses them. Thread-bound. Heap.
class ThreadStarter {
public:
    /// @param prefault_stack_kb  of each thread's stack, touched before its body
    explicit ThreadStarter(int prefault_stack_kb) : stack_bytes_(static_cast<std::size_t>(prefault_stack_kb) * 1024) {}

    /// Throws std::runtime_error if there can be no thread.
    void start(LinuxWorker& worker, const char* name, const ThreadOptions& options, Worker::Body body);
    /// The same for what may wait until nothing else wants a core.
    void start_in_background(LinuxWorker& worker, const char* name, Worker::Body body);
    void add_refusal(std::string refusal) { refusals_.push_back(std::move(refusal)); }
    /// Sentences for people.
    const std::vector<std::string>& refusals() const { return refusals_; }

private:
    void start(LinuxWorker& worker, const WorkerOptions& options, Worker::Body body);

    std::size_t stack_bytes_;
    std::vector<std::string> refusals_;
};

/// One thread a source, which waits in its driver and fills its queue (pump()). Usage: open(), then whatever takes from
/// the queues, then start(); join() before that ends, close() at last. Thread-bound to its owner but for ended() and
/// imu_ended().
class SensorThreads {
public:
    /// Everything is borrowed. @param wakeup  notified of every sample and end
    SensorThreads(Clock& clock, const Vehicle& vehicle, const RunSources& sources, RunQueues& queues,
                  LinuxWakeup& wakeup);
    ~SensorThreads() { join(); }
    SensorThreads(const SensorThreads&) = delete;
    SensorThreads& operator=(const SensorThreads&) = delete;

    /// Starts the sources; what they warn of counts as refused. Throws InputError if one cannot be started.
    /// @param in_flight  only one camera must start: an estimate with less is better than none, which a program that
    ///                   ends gives. The others are reported, and tried again by their threads
    void open(ThreadStarter& starter, bool in_flight = false);
    /// @param see  called on the IMU's thread with each sample before it is in its queue; may be empty
    void start(ThreadStarter& starter, std::function<void(const ImuSample&)> see);
    /// No more samples will come.
    bool ended() const;
    /// No more inertial samples will come.
    bool imu_ended() const { return imu_.ended.load(std::memory_order_acquire); }
    /// Ends the threads.
    void join();
    /// Stops the sources.
    void close();

    /// Of those that there are.
    std::vector<SourceAccount> accounts() const;
    /// Of all threads, also those that there are not.
    std::vector<EventQueue*> events() { return {&left_.events, &right_.events, &trigger_.events, &imu_.events}; }

private:
    Clock& clock_;
    const Vehicle& vehicle_;
    RunSources sources_;
    RunQueues& queues_;
    LinuxWakeup& wakeup_;
    std::function<void(const ImuSample&)> see_;
    SourceThread left_{"left"};
    SourceThread right_{"right"};
    SourceThread trigger_{"trigger"};
    SourceThread imu_{"imu"};
    LinuxWorker left_worker_;
    LinuxWorker right_worker_;
    LinuxWorker trigger_worker_;
    LinuxWorker imu_worker_;
};

/// What the synchroniser has to know of a vehicle's sensors, and what comes beside it. Reentrant. No heap.
IntakeOptions intake_options(const Vehicle& vehicle, const RunSources& sources);

/// The synchroniser's findings by name, for an account. Reentrant. Heap.
std::vector<NamedCounter> named_findings(const SharedFindings& findings);

}  // namespace facet
