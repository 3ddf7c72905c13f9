// SPDX-License-Identifier: BSD-2-Clause
// A thread with the properties that a real-time program asks for.
#pragma once

#include <atomic>
#include <functional>
#include <string>

#include "platform/base/status.h"

namespace facet {

struct WorkerOptions {
    std::string name;            ///< as shown by ps and top; 15 characters at most
    int cpu = -1;                ///< the core it stays on; -1 for any
    int fifo_priority = 0;       ///< 1 to 99 for SCHED_FIFO; 0 for the ordinary scheduler
    bool is_background = false;  ///< runs only while nothing else wants its core
};

/// What of the options the system granted; a refusal is no failure.
struct WorkerReport {
    bool named = false;
    bool pinned = false;
    bool realtime = false;
    std::string refusals;  ///< one sentence for each refusal; empty if none
};

/// One thread. Thread-bound to its owner, except stopping(). Heap in start().
class Worker {
public:
    /// Runs until it returns; looks at `stopping` at least every few milliseconds.
    using Body = std::function<void(const std::atomic<bool>& stopping)>;

    virtual ~Worker() = default;

    /// Starts the thread and waits until its properties are set.
    /// @return kInvalidArgument if it is running or the options are out of range, kIo if there can be no more threads.
    virtual Status start(const WorkerOptions& options, Body body, WorkerReport& report) = 0;
    /// Asks the body to return.
    virtual void request_stop() = 0;
    /// Waits for the body's return; at once if not running.
    virtual void join() = 0;
};

}  // namespace facet
