// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/sensor_threads.h"

#include <fmt/core.h>

#include <stdexcept>
#include <utility>

#include "app/support/input_error.h"
#include "platform/linux/memory_lock.h"

namespace facet {
namespace {

void open_source(Source& source, const char* name, ThreadStarter& starter) {
    if (!ok(source.start())) {
        throw InputError(fmt::format("{}: {}", name, source.problem()));
    }
    if (!source.warning().empty()) {
        starter.add_refusal(fmt::format("{}: {}", name, source.warning()));
    }
}

}  // namespace

void ThreadStarter::start(LinuxWorker& worker, const char* name, const ThreadOptions& options, Worker::Body body) {
    start(worker, {name, options.cpu, options.priority}, std::move(body));
}

void ThreadStarter::start_in_background(LinuxWorker& worker, const char* name, Worker::Body body) {
    start(worker, {.name = name, .is_background = true}, std::move(body));
}

void ThreadStarter::start(LinuxWorker& worker, const WorkerOptions& options, Worker::Body body) {
    WorkerReport report;
    const Status status = worker.start(
        options,
        [stack = stack_bytes_, body = std::move(body)](const std::atomic<bool>& stopping) {
            prefault_stack(stack);
            body(stopping);
        },
        report);
    if (!ok(status)) {
        throw std::runtime_error(fmt::format("thread {}: {}", options.name, to_string(status)));
    }
    if (!report.refusals.empty()) {
        add_refusal(report.refusals);
    }
}

SensorThreads::SensorThreads(Clock& clock, const Vehicle& vehicle, const RunSources& sources, RunQueues& queues,
                             LinuxWakeup& wakeup)
    : clock_(clock), vehicle_(vehicle), sources_(sources), queues_(queues), wakeup_(wakeup) {
    left_.name = vehicle.cameras.side_by_side ? "cameras" : "left";
}

void SensorThreads::open(ThreadStarter& starter, bool in_flight) {
    int cameras = 0;
    const auto open = [&](Source* source, const char* name, SourceThread& thread) {
        if (source == nullptr) {
            return false;
        }
        try {
            open_source(*source, name, starter);
            return true;
        } catch (const InputError& e) {
            if (!in_flight) {
                throw;
            }
            thread.is_awaited = true;
            (void)thread.events.push(RunEvent::make("source_failed", "{}; begun without it in flight", e.what()));
            return false;
        }
    };
    (void)open(sources_.imu, "imu", imu_);
    (void)open(sources_.trigger, "trigger", trigger_);
    cameras += open(sources_.left, vehicle_.cameras.side_by_side ? "cameras" : "left camera", left_) ? 1 : 0;
    cameras += open(sources_.right, "right camera", right_) ? 1 : 0;
    if (cameras == 0) {
        throw InputError(fmt::format("no camera can be started: {}", sources_.left->problem()));
    }
}

void SensorThreads::start(ThreadStarter& starter, std::function<void(const ImuSample&)> see) {
    see_ = see ? std::move(see) : [](const ImuSample&) {};
    const auto begin = [&](LinuxWorker& worker, const char* name, const ThreadOptions& options, auto* source,
                           SourceThread& shared, auto& queue, auto seen) {
        if (source == nullptr) {
            shared.ended = true;
            return;
        }
        starter.start(worker, name, options, [=, this, &shared, &queue](const std::atomic<bool>& stopping) {
            pump(*source, shared, clock_, wakeup_, stopping, queue, seen);
        });
    };
    const auto nothing = [](const auto&) {};
    const VehicleRealtime& realtime = vehicle_.realtime;
    begin(imu_worker_, "facet-imu", realtime.imu, sources_.imu, imu_, queues_.imu,
          [this](const ImuSample& sample) { see_(sample); });
    begin(trigger_worker_, "facet-trigger", realtime.trigger, sources_.trigger, trigger_, queues_.edges, nothing);
    begin(left_worker_, "facet-left", realtime.cameras, sources_.left, left_, queues_.left, nothing);
    begin(right_worker_, "facet-right", realtime.cameras, sources_.right, right_, queues_.right, nothing);
}

bool SensorThreads::ended() const {
    return left_.ended.load(std::memory_order_acquire) && right_.ended.load(std::memory_order_acquire) &&
           trigger_.ended.load(std::memory_order_acquire) && imu_.ended.load(std::memory_order_acquire);
}

void SensorThreads::join() {
    for (LinuxWorker* worker : {&left_worker_, &right_worker_, &trigger_worker_, &imu_worker_}) {
        worker->request_stop();
        worker->join();
    }
}

void SensorThreads::close() {
    sources_.left->stop();
    if (sources_.right != nullptr) {
        sources_.right->stop();
    }
    if (sources_.trigger != nullptr) {
        sources_.trigger->stop();
    }
    sources_.imu->stop();
}

std::vector<SourceAccount> SensorThreads::accounts() const {
    std::vector<SourceAccount> accounts{left_.counters.account(left_.name)};
    if (sources_.right != nullptr) {
        accounts.push_back(right_.counters.account(right_.name));
    }
    if (sources_.trigger != nullptr) {
        accounts.push_back(trigger_.counters.account(trigger_.name));
    }
    accounts.push_back(imu_.counters.account(imu_.name));
    return accounts;
}

IntakeOptions intake_options(const Vehicle& vehicle, const RunSources& sources) {
    SynchroniserOptions options;
    options.period = Duration::from_seconds(1.0 / vehicle.cameras.rate_hz);
    options.has_trigger = vehicle.trigger.has_value();
    options.use_sequence = vehicle.cameras.use_sequence;
    options.has_right = vehicle.calibration.rig.has_right;
    options.left_delay = options.right_delay = Duration{vehicle.cameras.lag_frames * options.period.ns};
    options.first_is_first = vehicle.trigger && vehicle.pulses;
    if (vehicle.trigger) {
        options.trigger_delay = vehicle.trigger->delay;
        options.trigger_silence = Duration{5 * options.period.ns};
    } else if (vehicle.cameras.side_by_side) {
        options.votes = 1;  // halves of one image need no evidence that they belong together
    }
    return {options, vehicle.calibration.camera_time_shift, vehicle.cameras.side_by_side, sources.ranges};
}

std::vector<NamedCounter> named_findings(const SharedFindings& findings) {
    std::vector<NamedCounter> named;
    for (std::size_t i = 0; i < findings.size(); ++i) {
        named.push_back({to_string(static_cast<SyncFault>(i)), findings[i]});
    }
    return named;
}

}  // namespace facet
