// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/record_run.h"

#include <fmt/core.h>

#include <utility>

#include "app/calibration/calibration.h"
#include "app/config/config_file.h"
#include "app/support/input_error.h"
#include "app/support/text_file.h"

namespace facet {
namespace {

constexpr Duration kCollectorWait = Duration::from_seconds(0.02);
constexpr auto kOnlyCounted = std::memory_order_relaxed;

}  // namespace

RecordRun::RecordRun(Clock& clock, const Vehicle& vehicle, const RunSources& sources, std::string folder)
    : clock_(clock),
      vehicle_(vehicle),
      sources_(sources),
      folder_(std::move(folder)),
      queues_(std::make_unique<RunQueues>()),
      sync_(synchroniser_options(vehicle)) {
    left_.name = vehicle.cameras.side_by_side ? "cameras" : "left";
}

RecordRun::~RecordRun() { join_all(); }

void RecordRun::join_all() {
    // In the order of the data: each thread stops after the ones that feed it.
    for (LinuxWorker* worker : {&left_worker_, &right_worker_, &trigger_worker_, &imu_worker_, &collector_, &writer_}) {
        worker->request_stop();
        wakeup_.notify();
        worker->join();
    }
}

template <class Body>
void RecordRun::start_worker(LinuxWorker& worker, const char* name, const ThreadOptions& options, Body body) {
    WorkerReport report;
    const Status status = worker.start({name, options.cpu, options.priority}, std::move(body), report);
    if (!ok(status)) {
        throw std::runtime_error(fmt::format("thread {}: {}", name, to_string(status)));
    }
    if (!report.refusals.empty()) {
        refusals_.push_back(report.refusals);
    }
}

void RecordRun::start_source(Source& source, const char* name) {
    if (!ok(source.start())) {
        throw InputError(fmt::format("{}: {}", name, source.problem()));
    }
}

void RecordRun::make_log() {
    const CameraIntrinsics k = vehicle_.calibration.rig.left.intrinsics();
    log_ = std::make_unique<SampleRecorder>(clock_, folder_, vehicle_.calibration.rig.has_right,
                                            static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height));
    keep_calibration(vehicle_.calibration, folder_ + "/mav0");
    TextFile parameters(folder_ + "/mav0/parameters.yaml");
    parameters.write(print_config(vehicle_.config));
    parameters.close();
}

void RecordRun::start() {
    start_source(*sources_.imu, "imu");
    if (sources_.trigger != nullptr) {
        start_source(*sources_.trigger, "trigger");
    }
    start_source(*sources_.left, vehicle_.cameras.side_by_side ? "cameras" : "left camera");
    if (sources_.right != nullptr) {
        start_source(*sources_.right, "right camera");
    }
    make_log();  // not before: a folder is not begun for sensors that are not there
    begin_ = clock_.now();
    // Consumers before producers.
    start_worker(writer_, "facet-record", {}, [this](const std::atomic<bool>& stopping) { log_->write(stopping); });
    start_worker(collector_, "facet-collect", vehicle_.realtime.estimator,
                 [this](const std::atomic<bool>& stopping) { collect(stopping); });
    start_sources();
}

void RecordRun::start_sources() {
    start_worker(imu_worker_, "facet-imu", vehicle_.realtime.imu, [this](const std::atomic<bool>& stopping) {
        pump(*sources_.imu, imu_, clock_, wakeup_, stopping, queues_->imu);
    });
    trigger_.ended = sources_.trigger == nullptr;
    if (sources_.trigger != nullptr) {
        start_worker(trigger_worker_, "facet-trigger", vehicle_.realtime.trigger,
                     [this](const std::atomic<bool>& stopping) {
                         pump(*sources_.trigger, trigger_, clock_, wakeup_, stopping, queues_->edges);
                     });
    }
    start_worker(left_worker_, "facet-left", vehicle_.realtime.cameras, [this](const std::atomic<bool>& stopping) {
        pump(*sources_.left, left_, clock_, wakeup_, stopping, queues_->left);
    });
    right_.ended = sources_.right == nullptr;
    if (sources_.right != nullptr) {
        start_worker(right_worker_, "facet-right", vehicle_.realtime.cameras,
                     [this](const std::atomic<bool>& stopping) {
                         pump(*sources_.right, right_, clock_, wakeup_, stopping, queues_->right);
                     });
    }
}

bool RecordRun::sources_ended() const {
    return left_.ended.load(std::memory_order_acquire) && right_.ended.load(std::memory_order_acquire) &&
           trigger_.ended.load(std::memory_order_acquire) && imu_.ended.load(std::memory_order_acquire);
}

bool RecordRun::ended() const {
    return collected_.load(std::memory_order_acquire) || log_->counters().failed.load(std::memory_order_acquire);
}

void RecordRun::collect(const std::atomic<bool>& stopping) {
    for (;;) {
        // Read before the step, which takes everything that arrived until then.
        const bool stopped = stopping.load(std::memory_order_acquire);
        const bool have_ended = sources_ended();
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

void RecordRun::add_both(CameraFrame both) {
    CameraFrame left = std::move(both);
    left.image.width /= 2;
    CameraFrame right{left.stamp, left.sequence, left.image, left.slot.share(), left.exposure};
    right.image.data += right.image.width;
    (void)sync_.add_left(std::move(left));  // refused ones are counted there
    (void)sync_.add_right(std::move(right));
}

bool RecordRun::take_images() {
    bool any = false;
    for (CameraFrame frame; ok(queues_->left.pop(frame)); any = true) {
        if (vehicle_.cameras.side_by_side) {
            add_both(std::move(frame));
        } else {
            (void)sync_.add_left(std::move(frame));
        }
        // One of the other camera between two of this one: neither fills the synchroniser alone.
        if (CameraFrame other; ok(queues_->right.pop(other))) {
            (void)sync_.add_right(std::move(other));
        }
    }
    for (CameraFrame frame; ok(queues_->right.pop(frame)); any = true) {
        (void)sync_.add_right(std::move(frame));
    }
    return any;
}

/// Takes what is in the queues. @return whether there was anything
bool RecordRun::step() {
    bool any = false;
    for (TriggerEdge edge; ok(queues_->edges.pop(edge)); any = true) {
        log_->on_edge(edge);
        (void)sync_.add_edge(edge);
        samples_.fetch_add(1, kOnlyCounted);
    }
    any = take_images() || any;
    for (ImuSample sample; ok(queues_->imu.pop(sample)); any = true) {
        log_->on_imu(sample);
        sync_.add_imu(sample.stamp - vehicle_.calibration.camera_time_shift);
        samples_.fetch_add(1, kOnlyCounted);
    }
    for (SyncedFrame pair; ok(sync_.pop(pair)); any = true) {
        log_->on_pair(pair);
    }
    for (SyncReport report; ok(sync_.pop_report(report));) {
    }
    for (std::size_t i = 0; i < findings_.size(); ++i) {
        findings_[i].store(sync_.count(static_cast<SyncFault>(i)), kOnlyCounted);
    }
    return any;
}

RecordStatus RecordRun::status() const {
    RecordStatus status;
    status.duration_s = (clock_.now() - begin_).seconds();
    status.pairs = log_->counters().pairs;
    status.pairs_dropped = log_->counters().pairs_dropped;
    status.samples = samples_;
    status.samples_dropped = log_->counters().samples_dropped;
    for (const SourceThread* source : {&left_, &right_, &trigger_, &imu_}) {
        const bool is_there =
            (source != &right_ || sources_.right != nullptr) && (source != &trigger_ || sources_.trigger != nullptr);
        if (is_there) {
            status.sources.push_back(source->counters.account(source->name));
        }
    }
    for (std::size_t i = 0; i < findings_.size(); ++i) {
        status.findings.push_back({to_string(static_cast<SyncFault>(i)), findings_[i]});
    }
    return status;
}

std::vector<std::string> RecordRun::take_events() {
    std::vector<std::string> lines;
    for (SourceThread* source : {&left_, &right_, &trigger_, &imu_}) {
        for (RunEvent event; ok(source->events.pop(event));) {
            lines.emplace_back(event.text.data());
        }
    }
    return lines;
}

RecordStatus RecordRun::stop() {
    join_all();
    sources_.left->stop();
    if (sources_.right != nullptr) {
        sources_.right->stop();
    }
    if (sources_.trigger != nullptr) {
        sources_.trigger->stop();
    }
    sources_.imu->stop();
    return status();
}

}  // namespace facet
