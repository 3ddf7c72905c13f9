// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/live_run.h"

#include <fmt/core.h>

#include "app/config/config_table.h"
#include "app/output/flight_folders.h"
#include "app/support/input_error.h"
#include "platform/linux/memory_lock.h"

namespace facet {
namespace {

constexpr Duration kEstimatorWait = Duration::from_seconds(0.02);
constexpr Duration kKeepPeriod = Duration::from_seconds(1.0);

}  // namespace

LiveRun::LiveRun(Clock& clock, const Vehicle& vehicle, const RunSources& sources, std::vector<OdometrySink*> sinks)
    : clock_(clock),
      vehicle_(vehicle),
      starter_(vehicle.realtime.prefault_stack_kb),
      queues_(std::make_unique<RunQueues>()),
      recorder_(vehicle.log.folder, {.timed_frames = static_cast<std::size_t>(vehicle.log.timed_frames),
                                     .mesh_faces = static_cast<std::size_t>(vehicle.log.mesh_faces),
                                     .map_faces = static_cast<std::size_t>(vehicle.log.mesh_faces)}),
      sensors_(clock, vehicle, sources, *queues_, wakeup_) {
    pipeline_.configure(vehicle.config, vehicle.calibration);
    if (vehicle.obstacles) {
        pipeline_.measure_ranges(*vehicle.obstacles, vehicle.odometry.T_body_imu);
    }
    if (vehicle.ros2_out && vehicle.ros2_out->has_grid) {
        pipeline_.keep_grid();
    }
    RunSummary& summary = recorder_.summary();
    summary.dataset = "live: " + vehicle.source;
    summary.mode = to_string(vehicle.config.regularity.mode);
    summary.parameters = changed_parameters(vehicle.config);
    summary.calibration = vehicle.calibration.source;
    output_ = std::make_unique<OutputThreads>(clock, vehicle.config, vehicle.odometry, std::move(sinks), recorder_,
                                              sensors_.events(), static_cast<std::size_t>(vehicle.log.timed_frames));
    const EstimatorLoopOptions options{intake_options(vehicle, sources)};
    loop_ = std::make_unique<EstimatorLoop>(options, clock, pipeline_, *queues_, *output_);
}

LiveRun::~LiveRun() { join_all(); }

void LiveRun::join_all() {
    // In the order of the data: each thread stops after the ones that feed it.
    sensors_.join();
    for (LinuxWorker* worker : {&estimator_, &map_worker_, &sender_, &writer_, &log_writer_, &keeper_worker_}) {
        worker->request_stop();
        wakeup_.notify();
        worker->join();
    }
}

/// Where they are is decided here: an earlier flight's files stay if this one cannot be.
void LiveRun::open_files() {
    folder_ = vehicle_.log.folder;
    if (folder_.empty()) {
        return;
    }
    LogKeeping keeping;
    if (vehicle_.log.by_flight) {
        constexpr std::uint64_t kMegabyte = 1'000'000;
        folder_ = begin_flight(vehicle_.log.folder);
        keeping = {folder_, vehicle_.log.folder, static_cast<std::uint64_t>(vehicle_.log.keep_mb) * kMegabyte};
    }
    keeping.folder = folder_;
    recorder_.open(folder_);
    keeper_ = std::make_unique<LogKeeper>(clock_, keeping);
    starter_.start(keeper_worker_, "facet-disc", {},
                   [this](const std::atomic<bool>& stopping) { keeper_->keep(stopping); });
}

void LiveRun::start_recorder() {
    if (!form_) {
        return;
    }
    if (folder_.empty()) {
        throw InputError("nothing can be recorded without a folder");
    }
    log_ = std::make_unique<FlightLog>(clock_, vehicle_, folder_, *form_, [this](std::vector<NamedCounter>& counts) {
        append(sensors_.accounts(), counts);
        append(named_findings(loop_->counters().findings), counts);
        append(drops(), counts);
    });
    loop_->show(&log_->samples());
    pipeline_.show_to(log_->add_estimates());
    starter_.start(log_writer_, "facet-record", {},
                   [this](const std::atomic<bool>& stopping) { log_->write(stopping); });
}

void LiveRun::start_map() {
    if (!folder_.empty()) {
        surface_.add(&recorder_.surface());
    }
    if (surface_.empty() || !vehicle_.config.map.enabled || !pipeline_.rig().has_right) {
        return;
    }
    map_ = std::make_unique<MapThread>(vehicle_.config.map, pipeline_.rig(), surface_);
    pipeline_.give_keyframes_to(map_.get());
    starter_.start_in_background(map_worker_, "facet-map",
                                 [this](const std::atomic<bool>& stopping) { map_->work(stopping); });
}

void LiveRun::start() {
    if (std::string refusal; vehicle_.realtime.lock_memory && !ok(lock_memory(refusal))) {
        starter_.add_refusal(refusal);
    }
    sensors_.open(starter_, is_in_flight_);
    open_files();
    if (WarningLog* log = recorder_.warnings(); log != nullptr && is_quiet_) {
        log->set_quiet();
    }
    begin_ = last_status_ = clock_.now();
    // Consumers before producers.
    start_recorder();
    start_map();
    starter_.start(writer_, "facet-files", {},
                   [this](const std::atomic<bool>& stopping) { output_->write_files(stopping); });
    starter_.start(sender_, "facet-sinks", vehicle_.realtime.output,
                   [this](const std::atomic<bool>& stopping) { output_->send_poses(stopping); });
    starter_.start(estimator_, "facet-estimator", vehicle_.realtime.estimator,
                   [this](const std::atomic<bool>& stopping) { estimate(stopping); });
    sensors_.start(starter_, [this](const ImuSample& sample) { output_->on_sample(sample); });
}

void LiveRun::estimate(const std::atomic<bool>& stopping) {
    for (;;) {
        // Read before the step, which takes everything that arrived until then.
        const bool stopped = stopping.load(std::memory_order_acquire);
        const bool ended = sensors_.ended();
        const bool imu_ended = sensors_.imu_ended();
        if (reset_requested_.exchange(false, std::memory_order_relaxed)) {
            pipeline_.request_reset();
        }
        const bool any = loop_->step() || (imu_ended && loop_->drop_frame());
        output_->on_beat();
        offer_state();
        if (stopped || (ended && !any)) {
            break;
        }
        if (!any) {
            (void)wakeup_.wait(kEstimatorWait);
        }
    }
    loop_->finish();
    output_->on_end();
    estimated_.store(true, std::memory_order_release);
}

/// A millisecond of the estimator's thread once a second; the file is another thread's business.
void LiveRun::offer_state() {
    if (!next_state_ || clock_.now() < *next_state_) {
        return;
    }
    if (const std::optional<KeptState> state = pipeline_.keep()) {
        (void)states_.push(*state);  // if it is full, nobody has asked for a second
        next_state_ = clock_.now() + kKeepPeriod;
    }
}

bool LiveRun::take_state(KeptState& state) {
    bool any = false;
    while (ok(states_.pop(state))) {
        any = true;
    }
    return any;
}

RunStatus LiveRun::status() {
    RunStatus status;
    const Timestamp now = clock_.now();
    status.uptime_s = (now - begin_).seconds();
    const std::uint64_t used = loop_->counters().used.load(std::memory_order_relaxed);
    const double span_s = (now - last_status_).seconds();
    status.rate_hz = span_s > 0.0 ? static_cast<double>(used - last_frames_) / span_s : 0.0;
    last_status_ = now;
    last_frames_ = used;
    status.frame = output_->status();
    const LiveAccount so_far = account();
    status.late = loop_->counters().late.load(std::memory_order_relaxed);
    status.overruns = so_far.overruns;
    const OutputCounters& dropped = output_->counters();
    status.outputs_dropped = dropped.poses_dropped + dropped.frames_dropped + dropped.refused;
    status.sources = so_far.sources;
    return status;
}

/// What was lost behind the sensors, by reason. On any thread.
std::vector<NamedCounter> LiveRun::drops() const {
    const LoopCounters& loop = loop_->counters();
    const OutputCounters& output = output_->counters();
    std::vector<NamedCounter> drops{{"late_frames", loop.late},
                                    {"frames_refused_by_estimator", loop.refused},
                                    {"poses", output.poses_dropped},
                                    {"poses_refused_by_sinks", output.refused},
                                    {"frames_not_written", output.frames_dropped},
                                    {"faces_not_written", output.faces_dropped}};
    if (map_) {
        drops.push_back({"keyframes_not_mapped", map_->dropped()});
    }
    if (log_) {
        append(log_->drops(), drops);
    }
    return drops;
}

/// All but the latencies, which belong to the sending thread.
LiveAccount LiveRun::account() const {
    LiveAccount account;
    account.duration_s = (clock_.now() - begin_).seconds();
    const LoopCounters& loop = loop_->counters();
    account.overruns = loop.overruns;
    account.poses = output_->counters().poses_sent;
    account.drops = drops();
    account.findings = named_findings(loop.findings);
    account.sources = sensors_.accounts();
    account.refusals = starter_.refusals();
    return account;
}

RunSummary LiveRun::stop() {
    const bool had_ended = ended();
    join_all();
    sensors_.close();
    RunSummary& summary = recorder_.summary();
    summary.interrupted = !had_ended;
    summary.frames_listed = loop_->counters().paired;
    summary.live = account();
    summary.live->latency_ms = output_->latencies_ms();
    summary.wall_s = summary.live->duration_s;
    output_->add_end(summary.last.health);
    failure_ = output_->failure();
    if (log_) {
        log_->finish();
    }
    pipeline_.finish_places();
    if (map_) {
        map_->finish();
    }
    try {
        if (failure_.empty()) {
            recorder_.finish(pipeline_, map_ ? &map_->map() : nullptr);
        }
    } catch (const InputError& e) {
        failure_ = e.what();  // the flight is over; what was written so far stays
    }
    if (failure_.empty() && log_) {
        failure_ = log_->failure();
    }
    if (keeper_) {
        keeper_->sync();
        failure_ = failure_.empty() ? keeper_->failure() : failure_;
    }
    return summary;
}

}  // namespace facet
