// SPDX-License-Identifier: BSD-2-Clause
// A thread of Linux with name, core and real-time priority.
#pragma once

#include <thread>

#include "platform/port/worker.h"

namespace facet {

/// A std::thread that sets its own properties before it runs the body; the destructor stops and joins it.
class LinuxWorker final : public Worker {
public:
    LinuxWorker() = default;
    ~LinuxWorker() override;
    LinuxWorker(const LinuxWorker&) = delete;
    LinuxWorker& operator=(const LinuxWorker&) = delete;

    Status start(const WorkerOptions& options, Body body, WorkerReport& report) override;
    void request_stop() override { stopping_.store(true, std::memory_order_relaxed); }
    void join() override;

private:
    std::thread thread_;
    std::atomic<bool> stopping_{false};
};

}  // namespace facet
