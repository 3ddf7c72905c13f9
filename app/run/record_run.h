// SPDX-License-Identifier: BSD-2-Clause
// Live sensors into a log, without an estimator.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "app/config/vehicle.h"
#include "app/output/live_account.h"
#include "app/run/flight_log.h"
#include "app/run/intake.h"
#include "app/run/sensor_threads.h"
#include "platform/linux/linux_worker.h"

namespace facet {

/// What a recording has so far.
struct RecordStatus {
    double duration_s = 0.0;
    std::uint64_t pairs = 0;          ///< written; single images of a pair among them
    std::uint64_t pairs_dropped = 0;  ///< see RecordCounters
    std::uint64_t samples = 0;        ///< inertial samples and edges, given to the writer
    std::uint64_t samples_dropped = 0;
    std::vector<SourceAccount> sources;
    std::vector<NamedCounter> findings;  ///< of the synchroniser
};

/// Runs the threads of LiveRun that come before the estimator, with the same queues, and in its place one that pairs
/// images and hands everything to a FlightLog, which is that of `facet run --record`: readable to within a second at
/// every moment, whatever happens. Thread-bound to its owner.
class RecordRun {
public:
    /// Everything is borrowed. @param folder  gets the log, which must not be there yet
    RecordRun(Clock& clock, const Vehicle& vehicle, const RunSources& sources, std::string folder, LogForm form);
    ~RecordRun();
    RecordRun(const RecordRun&) = delete;
    RecordRun& operator=(const RecordRun&) = delete;

    /// Throws InputError if a source cannot be started, or the log cannot be made.
    void start();
    /// All sources have ended and are recorded, or nothing can be written any more.
    bool ended() const;
    RecordStatus status() const;
    /// What sources have reported since the last call: a line each.
    std::vector<std::string> take_events();
    const std::vector<std::string>& refusals() const { return starter_.refusals(); }

    /// Stops everything in the order of the data, so that all that has arrived is written.
    RecordStatus stop();
    /// After start(): where the log is.
    const std::string& path() const { return log_->path(); }
    /// After stop(): why the log is incomplete; empty if it is complete.
    const std::string& failure() const { return log_->failure(); }

private:
    void make_log();
    void collect(const std::atomic<bool>& stopping);
    bool step();
    void join_all();

    Clock& clock_;
    const Vehicle& vehicle_;
    std::string folder_;
    LogForm form_;
    ThreadStarter starter_;
    std::unique_ptr<RunQueues> queues_;
    LinuxWakeup wakeup_;
    SensorThreads sensors_;
    Intake intake_;  ///< of the collecting thread
    SharedFindings findings_{};
    std::atomic<std::uint64_t> samples_{0};
    std::unique_ptr<FlightLog> log_;
    std::atomic<bool> collected_{false};
    Timestamp begin_;
    LinuxWorker writer_;
    LinuxWorker collector_;
};

}  // namespace facet
