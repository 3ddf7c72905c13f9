// SPDX-License-Identifier: BSD-2-Clause
#include "platform/linux/linux_worker.h"

#include <pthread.h>
#include <sched.h>

#include <cstring>
#include <future>
#include <system_error>
#include <utility>

namespace facet {
namespace {

constexpr std::size_t kMaxName = 15;  // what the kernel keeps

void refuse(WorkerReport& report, const WorkerOptions& options, const char* what, int error) {
    report.refusals += options.name + ": " + what + ": " + std::strerror(error) + ". ";
}

/// Sets the properties of the calling thread.
WorkerReport apply(const WorkerOptions& options) {
    WorkerReport report;
    if (!options.name.empty()) {
        const int error = pthread_setname_np(pthread_self(), options.name.c_str());
        report.named = error == 0;
        if (error != 0) {
            refuse(report, options, "no name", error);
        }
    }
    if (options.cpu >= 0) {
        cpu_set_t cores;
        CPU_ZERO(&cores);
        CPU_SET(static_cast<std::size_t>(options.cpu), &cores);
        const int error = pthread_setaffinity_np(pthread_self(), sizeof cores, &cores);
        report.pinned = error == 0;
        if (error != 0) {
            refuse(report, options, "not pinned to its core", error);
        }
    }
    if (options.is_background) {
        const sched_param parameters{};
        const int error = pthread_setschedparam(pthread_self(), SCHED_IDLE, &parameters);
        if (error != 0) {
            refuse(report, options, "not in the background", error);
        }
    } else if (options.fifo_priority > 0) {
        sched_param parameters{};
        parameters.sched_priority = options.fifo_priority;
        const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);
        report.realtime = error == 0;
        if (error != 0) {
            refuse(report, options, "no real-time priority", error);
        }
    }
    return report;
}

}  // namespace

LinuxWorker::~LinuxWorker() {
    request_stop();
    join();
}

Status LinuxWorker::start(const WorkerOptions& options, Body body, WorkerReport& report) {
    if (thread_.joinable() || !body || options.name.size() > kMaxName || options.cpu >= CPU_SETSIZE ||
        options.fifo_priority < 0 || options.fifo_priority > 99 ||
        (options.is_background && options.fifo_priority > 0)) {
        return Status::kInvalidArgument;
    }
    stopping_.store(false, std::memory_order_relaxed);
    std::promise<WorkerReport> applied;
    std::future<WorkerReport> result = applied.get_future();
    try {
        thread_ = std::thread([this, options, body = std::move(body), applied = std::move(applied)]() mutable {
            applied.set_value(apply(options));
            body(stopping_);
        });
    } catch (const std::system_error&) {
        return Status::kIo;
    }
    report = result.get();
    return Status::kOk;
}

void LinuxWorker::join() {
    if (thread_.joinable()) {
        thread_.join();
    }
}

}  // namespace facet
