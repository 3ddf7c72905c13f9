// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/record_run.h"

#include <utility>

namespace facet {
namespace {

constexpr Duration kCollectorWait = Duration::from_seconds(0.02);
constexpr auto kOnlyCounted = std::memory_order_relaxed;

}  // namespace

RecordRun::RecordRun(Clock& clock, const Vehicle& vehicle, const RunSources& sources, std::string folder, LogForm form)
    : clock_(clock),
      vehicle_(vehicle),
      folder_(std::move(folder)),
      form_(form),
      starter_(vehicle.realtime.prefault_stack_kb),
      queues_(std::make_unique<RunQueues>()),
      sensors_(clock, vehicle, sources, *queues_, wakeup_),
      intake_(intake_options(vehicle, sources), *queues_) {}

RecordRun::~RecordRun() { join_all(); }

void RecordRun::join_all() {
    // In the order of the data: each thread stops after the ones that feed it.
    sensors_.join();
    for (LinuxWorker* worker : {&collector_, &writer_}) {
        worker->request_stop();
        wakeup_.notify();
        worker->join();
    }
}

void RecordRun::make_log() {
    log_ = std::make_unique<FlightLog>(clock_, vehicle_, folder_, form_, [this](std::vector<NamedCounter>& counts) {
        append(sensors_.accounts(), counts);
        append(named_findings(findings_), counts);
        append(log_->drops(), counts);
    });
    intake_.show(&log_->samples());
}

void RecordRun::start() {
    sensors_.open(starter_);
    make_log();  // not before: a folder is not begun for sensors that are not there
    begin_ = clock_.now();
    // Consumers before producers.
    starter_.start(writer_, "facet-record", {}, [this](const std::atomic<bool>& stopping) { log_->write(stopping); });
    starter_.start(collector_, "facet-collect", vehicle_.realtime.estimator,
                   [this](const std::atomic<bool>& stopping) { collect(stopping); });
    sensors_.start(starter_, {});
}

bool RecordRun::ended() const {
    return collected_.load(std::memory_order_acquire) || log_->counters().failed.load(std::memory_order_acquire);
}

void RecordRun::collect(const std::atomic<bool>& stopping) {
    for (;;) {
        // Read before the step, which takes everything that arrived until then.
        const bool stopped = stopping.load(std::memory_order_acquire);
        const bool have_ended = sensors_.ended();
        const bool any = step();
        if (!any && (stopped || have_ended)) {
            break;
        }
        if (!any) {
            (void)wakeup_.wait(kCollectorWait);
        }
    }
    collected_.store(true, std::memory_order_release);
}

/// Takes what is in the queues. @return whether there was anything
bool RecordRun::step() {
    std::size_t samples = intake_.take_edges();
    bool any = intake_.take_images([] {});
    samples += intake_.take_inertial([](const ImuSample&) {});
    samples_.fetch_add(samples, kOnlyCounted);
    for (SyncedFrame pair; intake_.pop(pair);) {  // the tap has it
        any = true;
        // As an estimator would have had them.
        intake_.take_ranges(pair.stamp + vehicle_.calibration.camera_time_shift, [](const RangeSample&) {});
    }
    for (SyncReport report; ok(intake_.sync().pop_report(report));) {
    }
    intake_.publish(findings_);
    return any || samples > 0;
}

RecordStatus RecordRun::status() const {
    RecordStatus status;
    status.duration_s = (clock_.now() - begin_).seconds();
    status.pairs = log_->counters().pairs;
    status.pairs_dropped = log_->counters().pairs_dropped;
    status.samples = samples_;
    status.samples_dropped = log_->counters().samples_dropped;
    status.sources = sensors_.accounts();
    status.findings = named_findings(findings_);
    return status;
}

std::vector<std::string> RecordRun::take_events() {
    std::vector<std::string> lines;
    for (EventQueue* events : sensors_.events()) {
        for (RunEvent event; ok(events->pop(event));) {
            lines.emplace_back(event.text.data());
        }
    }
    return lines;
}

RecordStatus RecordRun::stop() {
    join_all();
    sensors_.close();
    if (log_) {
        log_->finish();
    }
    return status();
}

}  // namespace facet
