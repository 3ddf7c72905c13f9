// SPDX-License-Identifier: BSD-2-Clause
// The work of a sensor's thread: waits for samples and puts them into a queue.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

#include "app/output/live_account.h"
#include "app/run/run_event.h"
#include "app/run/stamp_mapper.h"
#include "platform/linux/linux_wakeup.h"
#include "platform/port/source.h"

namespace facet {

/// SourceCounters, and what is lost on the way to the estimator; readable from any thread.
class SharedCounters {
public:
    void publish(const SourceCounters& c) {
        delivered_.store(c.delivered, kOrder);
        lost_.store(c.lost, kOrder);
        corrupt_.store(c.corrupt, kOrder);
        discarded_.store(c.discarded, kOrder);
        errors_.store(c.errors, kOrder);
        recoveries_.store(c.recoveries, kOrder);
    }
    void add_rejected() { rejected_.fetch_add(1, kOrder); }
    void add_unmapped() { unmapped_.fetch_add(1, kOrder); }

    SourceAccount account(std::string name) const {
        return {std::move(name),
                {delivered_.load(kOrder), lost_.load(kOrder), corrupt_.load(kOrder), discarded_.load(kOrder),
                 errors_.load(kOrder), recoveries_.load(kOrder)},
                rejected_.load(kOrder),
                unmapped_.load(kOrder)};
    }

private:
    static constexpr auto kOrder = std::memory_order_relaxed;
    std::atomic<std::uint64_t> delivered_{0};
    std::atomic<std::uint64_t> lost_{0};
    std::atomic<std::uint64_t> corrupt_{0};
    std::atomic<std::uint64_t> discarded_{0};
    std::atomic<std::uint64_t> errors_{0};
    std::atomic<std::uint64_t> recoveries_{0};
    std::atomic<std::uint64_t> rejected_{0};
    std::atomic<std::uint64_t> unmapped_{0};
};

/// State of one sensor's thread, shared with the others.
struct SourceThread {
    explicit SourceThread(std::string source_name) : name(std::move(source_name)) {}

    std::string name;  ///< as in the account and in ps
    SharedCounters counters;
    EventQueue events;
    std::atomic<bool> ended{false};  ///< no more samples will come
    bool is_awaited = false;         ///< the source could not be started yet; of its thread once that runs
};

/// Longest wait in the driver: how long a stop may take.
inline constexpr Duration kSourceWait = Duration::from_seconds(0.05);
/// Pause after a source returned without a sample and without waiting, as closed and failing ones do.
inline constexpr Duration kSourcePause = Duration::from_seconds(0.005);
/// A source that could not be started is tried again after so many waits: half a second.
inline constexpr int kSourceRetry = 10;

/// Tries to start a source that is awaited, until `stopping`.
template <class Source>
void await_source(Source& source, SourceThread& shared, Clock& clock, const std::atomic<bool>& stopping) {
    for (int waits = 1; shared.is_awaited && !stopping.load(std::memory_order_relaxed); ++waits) {
        clock.sleep(kSourceWait);
        shared.is_awaited = waits % kSourceRetry != 0 || !ok(source.start());
    }
}

/// Body of a sensor's thread: until `stopping` or the end of the stream. The source has been started, or is awaited. A
/// sample that finds the queue full is dropped and counted.
/// @param see  called with each sample before it is in the queue
template <class Source, class Sample, std::size_t N, class See>
void pump(Source& source, SourceThread& shared, Clock& clock, LinuxWakeup& wakeup, const std::atomic<bool>& stopping,
          SpscQueue<Sample, N>& queue, See see) {
    StampMapper mapper(clock, source.clock());
    bool failing = shared.is_awaited;  // which has been reported
    await_source(source, shared, clock, stopping);
    while (!stopping.load(std::memory_order_relaxed)) {
        Sample sample;
        const Timestamp begin = clock.now();
        const Status status = source.next(kSourceWait, sample);
        shared.counters.publish(source.counters());
        if (ok(status)) {
            if (failing) {
                failing = false;
                (void)shared.events.push(RunEvent::make("recovered", "{}: works again", shared.name));
            }
            if (!ok(mapper.map(sample.stamp))) {
                shared.counters.add_unmapped();
                continue;
            }
            see(sample);
            if (!ok(queue.push(std::move(sample)))) {
                shared.counters.add_rejected();
            }
            wakeup.notify();
            continue;
        }
        if (status == Status::kEndOfStream) {
            break;
        }
        if (status == Status::kIo && !failing) {
            failing = true;
            (void)shared.events.push(RunEvent::make("source_failed", "{}: {}", shared.name, source.problem()));
        }
        if (status != Status::kCorrupt && clock.now() - begin < kSourcePause) {
            clock.sleep(kSourcePause);
        }
    }
    shared.ended.store(true, std::memory_order_release);
    wakeup.notify();
}

template <class Source, class Sample, std::size_t N>
void pump(Source& source, SourceThread& shared, Clock& clock, LinuxWakeup& wakeup, const std::atomic<bool>& stopping,
          SpscQueue<Sample, N>& queue) {
    pump(source, shared, clock, wakeup, stopping, queue, [](const Sample&) {});
}

}  // namespace facet
