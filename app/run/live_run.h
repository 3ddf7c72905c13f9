// SPDX-License-Identifier: BSD-2-Clause
// The estimator on live sensors: threads, their queues, and what they leave behind.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/config/vehicle.h"
#include "app/output/summary.h"
#include "app/run/flight_log.h"
#include "app/run/log_keeper.h"
#include "app/run/map_thread.h"
#include "app/run/output_threads.h"
#include "app/run/sensor_threads.h"
#include "platform/linux/linux_worker.h"

namespace facet {

/// The state of a run, for people and for systemd.
struct RunStatus {
    double uptime_s = 0.0;
    double rate_hz = 0.0;  ///< of frames used, since the last status
    FrameStatus frame;
    std::uint64_t late = 0;
    std::uint64_t overruns = 0;
    std::uint64_t outputs_dropped = 0;
    std::vector<SourceAccount> sources;
};

/// Runs one thread per source, one for the estimator, one for the sinks and one for the files. Usage:
///   LiveRun run(clock, vehicle, sources, sinks);
///   run.start();
///   while (!stop && !run.ended()) { wait; run.status(); }
///   RunSummary summary = run.stop();
/// What the system refuses (cores, priorities, locked memory) is listed in refusals(), and the run goes on without it.
/// Thread-bound to its owner. Throws InputError if files or parameters cannot be used, start() also if a source cannot
/// be started.
class LiveRun {
public:
    /// Everything is borrowed and must outlive the run.
    LiveRun(Clock& clock, const Vehicle& vehicle, const RunSources& sources, std::vector<OdometrySink*> sinks);
    ~LiveRun();
    LiveRun(const LiveRun&) = delete;
    LiveRun& operator=(const LiveRun&) = delete;

    void start();
    /// All sources have ended and everything is estimated.
    bool ended() const { return estimated_.load(std::memory_order_acquire); }
    /// Frames used so far.
    std::uint64_t frames() const { return output_->frames(); }
    RunStatus status();
    /// Lets the estimator restart at its next frame. On any thread.
    void request_reset() { reset_requested_.store(true, std::memory_order_relaxed); }
    const std::vector<std::string>& refusals() const { return starter_.refusals(); }
    /// After start(): where the files of this flight are; empty if there are none.
    const std::string& folder() const { return folder_; }
    /// To be called before start(): warnings are shown in the status only, not on stderr.
    void set_quiet() { is_quiet_ = true; }
    /// To be called before start(): records what the estimator is given as a log in folder(), see FlightLog. start()
    /// throws InputError if there is a log already, or no folder.
    void record(LogForm form) { form_ = form; }

    /// To be called before start(): goes on from what an earlier run has kept. @return see Estimator::resume()
    Status resume(const KeptState& kept, double elapsed_s) { return pipeline_.resume(kept, elapsed_s); }
    /// To be called before start(): the vehicle may be in the air, so that sensors which can be done without are waited
    /// for, see SensorThreads::open().
    void begin_in_flight() { is_in_flight_ = true; }
    /// To be called before start(): take_state() has a state to keep, once a second.
    void keep_states() { next_state_ = Timestamp{}; }
    /// @return whether there is a new one
    bool take_state(KeptState& state);
    /// Without it nothing that is to be used is sent: see OutputThreads.
    const char* silent_thread() const { return output_->silent_thread(); }
    /// Only a new program helps: see OutputThreads.
    const char* hanging_thread() const { return output_->hanging_thread(); }

    /// To be called before start(): see FramePipeline.
    void remember_places(std::span<const MappedPlace> known) { pipeline_.remember_places(known); }
    /// After stop(): null without remember_places().
    const PlaceMemory* places() const { return pipeline_.places(); }

    /// To be called before start(): mesh, planes and grid go there. Borrowed.
    void stream_to(WorldServer* world) { pipeline_.stream_to(world); }
    /// To be called before start(): every usable frame goes there. Borrowed.
    void show_to(FlightViewer* viewer) { pipeline_.show_to(viewer); }
    /// To be called before start(): the surface of the map goes there, on the map's thread. Borrowed; nullptr: to
    /// nobody more. Without it and without files no map is kept.
    void show_surface_to(SurfaceSink* sink) { surface_.add(sink); }

    /// Stops everything in the order of the data, so that all that was estimated is sent and written.
    RunSummary stop();
    /// After stop(): why files are incomplete; empty if they are complete.
    const std::string& failure() const { return failure_; }

private:
    void open_files();
    void start_recorder();
    void start_map();
    void estimate(const std::atomic<bool>& stopping);
    void offer_state();
    void join_all();
    LiveAccount account() const;
    std::vector<NamedCounter> drops() const;

    Clock& clock_;
    const Vehicle& vehicle_;
    ThreadStarter starter_;
    std::string failure_;
    bool is_quiet_ = false;
    bool is_in_flight_ = false;
    std::unique_ptr<RunQueues> queues_;
    FramePipeline pipeline_;
    FrameRecorder recorder_;
    LinuxWakeup wakeup_;
    SensorThreads sensors_;
    std::unique_ptr<OutputThreads> output_;
    std::string folder_;
    std::optional<LogForm> form_;  ///< none: not recorded
    std::unique_ptr<LogKeeper> keeper_;
    std::unique_ptr<FlightLog> log_;
    std::unique_ptr<EstimatorLoop> loop_;
    std::atomic<bool> estimated_{false};
    std::atomic<bool> reset_requested_{false};
    std::optional<Timestamp> next_state_;  ///< when one is to be kept; of the estimator's thread after start()
    SpscQueue<KeptState, 2> states_;
    Timestamp begin_;
    Timestamp last_status_;
    std::uint64_t last_frames_ = 0;
    SurfaceSinks surface_;
    std::unique_ptr<MapThread> map_;  ///< null: none is kept
    LinuxWorker map_worker_;
    LinuxWorker sender_;
    LinuxWorker writer_;
    LinuxWorker log_writer_;
    LinuxWorker keeper_worker_;
    LinuxWorker estimator_;
};

}  // namespace facet
