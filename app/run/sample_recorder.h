// SPDX-License-Identifier: BSD-2-Clause
// Records what the estimator is given, on a thread of its own.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "app/output/sample_log.h"
#include "app/run/sample_tap.h"
#include "platform/base/slot_lease.h"
#include "platform/base/spsc_queue.h"
#include "platform/linux/linux_wakeup.h"
#include "platform/port/clock.h"

namespace facet {

/// May be read from any thread.
struct RecordCounters {
    std::atomic<std::uint64_t> pairs{0};            ///< written
    std::atomic<std::uint64_t> pairs_dropped{0};    ///< because no buffer was free, or nothing can be written any more
    std::atomic<std::uint64_t> samples_dropped{0};  ///< inertial samples, edges, ranges, likewise
    std::atomic<bool> failed{false};                ///< nothing can be written any more
};

/// The tap's functions copy a sample and return; they use neither heap nor lock. Copies, because a camera's slots must
/// not wait for a disk. Buffers: 32 pairs (1.6 s at 20 Hz), 8192 inertial samples, 512 edges, 512 ranges; when full,
/// the newest are dropped and counted. The log is a readable one to within kCommit at every moment (SampleLog). When it
/// cannot be written any more (a full disk), what there is stays readable, the rest is dropped and counted, and
/// failure() says why.
class SampleRecorder final : public SampleTap {
public:
    static constexpr std::size_t kPairs = 32;
    static constexpr Duration kCommit = Duration::from_seconds(0.5);

    /// @param pixels  of one camera's image: larger images are dropped
    SampleRecorder(const Clock& clock, std::unique_ptr<SampleLog> log, std::size_t pixels);

    /// To be called before write(): what else goes into the log, called on the writing thread as often as samples are
    /// looked for. Its exceptions end the writing, like the log's own.
    void write_also(std::function<void()> more) { more_ = std::move(more); }

    void on_imu(const ImuSample& sample) override;
    void on_edge(const TriggerEdge& edge) override;
    void on_range(const RangeSample& sample, Timestamp frame) override;
    void on_pair(const SyncedFrame& pair) override;

    /// After the body has returned: completes the log, unless writing has failed.
    void finish();
    /// Body of the writing thread: returns when it is `stopping` and all is written.
    void write(const std::atomic<bool>& stopping);

    const RecordCounters& counters() const { return counters_; }
    /// Likewise: why the log is incomplete; empty if it is complete.
    const std::string& failure() const { return failure_; }

private:
    struct Pair {
        PairOrigin origin;
        ImageView left;  ///< in the slot
        ImageView right;
        SlotLease slot;
    };
    struct Range {
        RangeSample sample;
        Timestamp frame;
    };
    bool write_some();
    void drop_waiting();

    const Clock& clock_;
    std::size_t pixels_;
    std::unique_ptr<SampleLog> log_;
    std::function<void()> more_;
    std::vector<std::uint8_t> pool_;  ///< two images a slot
    SlotLender<kPairs> slots_;
    SpscQueue<Pair, kPairs> pairs_;
    SpscQueue<ImuSample, 8192> samples_;
    SpscQueue<TriggerEdge, 512> edges_;
    SpscQueue<Range, 512> ranges_;
    LinuxWakeup wakeup_;
    RecordCounters counters_;
    std::string failure_;
};

}  // namespace facet
