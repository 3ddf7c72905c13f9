// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/sample_recorder.h"

#include <exception>
#include <utility>

#include "platform/base/image_copy.h"

namespace facet {
namespace {

constexpr Duration kRecordPoll = Duration::from_seconds(0.1);
constexpr auto kUnordered = std::memory_order_relaxed;

}  // namespace

SampleRecorder::SampleRecorder(const Clock& clock, std::unique_ptr<SampleLog> log, std::size_t pixels)
    : clock_(clock), pixels_(pixels), log_(std::move(log)), pool_(2 * pixels * kPairs) {}

void SampleRecorder::on_imu(const ImuSample& sample) {
    counters_.samples_dropped.fetch_add(ok(samples_.push(sample)) ? 0 : 1, kUnordered);
}

void SampleRecorder::on_edge(const TriggerEdge& edge) {
    counters_.samples_dropped.fetch_add(ok(edges_.push(edge)) ? 0 : 1, kUnordered);
}

void SampleRecorder::on_range(const RangeSample& sample, Timestamp frame) {
    counters_.samples_dropped.fetch_add(ok(ranges_.push({sample, frame})) ? 0 : 1, kUnordered);
}

void SampleRecorder::on_pair(const SyncedFrame& pair) {
    Pair kept;
    kept.slot = slots_.take();
    if (!kept.slot.held()) {
        counters_.pairs_dropped.fetch_add(1, kUnordered);
        return;
    }
    kept.origin = {pair.stamp,
                   {pair.left.stamp, pair.right.stamp},
                   {pair.left.sequence, pair.right.sequence},
                   {pair.left.exposure, pair.right.exposure}};
    std::uint8_t* const buffer = pool_.data() + 2 * pixels_ * static_cast<std::size_t>(kept.slot.slot());
    kept.left = copy_if_it_fits(pair.left.image, {buffer, pixels_});
    kept.right = copy_if_it_fits(pair.right.image, {buffer + pixels_, pixels_});
    counters_.pairs_dropped.fetch_add(ok(pairs_.push(std::move(kept))) ? 0 : 1, kUnordered);
    wakeup_.notify();
}

/// What waits, but of the pairs only one, so that the queues of samples do not wait for images. @return whether there
/// was a pair
bool SampleRecorder::write_some() {
    if (more_) {
        more_();
    }
    for (ImuSample sample; ok(samples_.pop(sample));) {
        log_->add_imu(sample);
    }
    for (TriggerEdge edge; ok(edges_.pop(edge));) {
        log_->add_edge(edge);
    }
    for (Range range; ok(ranges_.pop(range));) {
        log_->add_range(range.sample, range.frame);
    }
    Pair pair;
    if (!ok(pairs_.pop(pair))) {
        return false;
    }
    log_->add_pair(pair.origin, pair.left, pair.right);
    counters_.pairs.fetch_add(1, kUnordered);
    return true;
}

void SampleRecorder::drop_waiting() {
    for (Pair pair; ok(pairs_.pop(pair)); pair = {}) {
        counters_.pairs_dropped.fetch_add(1, kUnordered);
    }
    for (ImuSample sample; ok(samples_.pop(sample));) {
        counters_.samples_dropped.fetch_add(1, kUnordered);
    }
    for (Range range; ok(ranges_.pop(range));) {
        counters_.samples_dropped.fetch_add(1, kUnordered);
    }
    for (TriggerEdge edge; ok(edges_.pop(edge));) {
        counters_.samples_dropped.fetch_add(1, kUnordered);
    }
}

void SampleRecorder::write(const std::atomic<bool>& stopping) {
    Timestamp next_commit = clock_.now() + kCommit;
    for (;;) {
        const bool last = stopping.load(std::memory_order_acquire);
        bool any = false;
        try {
            while (failure_.empty() && write_some()) {
                any = true;
                if (clock_.now() >= next_commit) {
                    break;
                }
            }
            if (failure_.empty() && (clock_.now() >= next_commit || (last && !any))) {
                next_commit = clock_.now() + kCommit;
                log_->commit();
            }
        } catch (const std::exception& e) {
            failure_ = e.what();
            counters_.failed.store(true, std::memory_order_release);
            try {
                log_->commit();                // rows of what was still written
            } catch (const std::exception&) {  // the disc is full: the first reason counts
            }
        }
        if (!failure_.empty()) {
            drop_waiting();
        }
        if (last && !any) {
            return;
        }
        if (!any) {
            (void)wakeup_.wait(kRecordPoll);
        }
    }
}

void SampleRecorder::finish() {
    if (!failure_.empty()) {
        return;
    }
    try {
        log_->close();
    } catch (const std::exception& e) {
        failure_ = e.what();
    }
}

}  // namespace facet
