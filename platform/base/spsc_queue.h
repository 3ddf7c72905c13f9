// SPDX-License-Identifier: BSD-2-Clause
// The bounded, lock-free way from one sensor thread to the estimator thread.
#pragma once

#include <atomic>
#include <boost/lockfree/policies.hpp>
#include <boost/lockfree/spsc_queue.hpp>
#include <cstddef>
#include <cstdint>

#include "platform/base/status.h"

namespace facet {

/// A wait-free queue of at most N values between one producer thread and one consumer thread, over
/// boost::lockfree::spsc_queue with storage in place.
/// When full: push rejects (kFull, the queue is unchanged) and counts it in rejected().
/// Thread-safe for exactly one pushing and one popping thread. No heap (beyond what T itself does).
template <class T, std::size_t N>
class SpscQueue {
public:
    static constexpr std::size_t capacity() { return N; }

    /// Producer only. kFull if the consumer has fallen behind.
    Status push(const T& value) {
        if (queue_.push(value)) {
            return Status::kOk;
        }
        rejected_.fetch_add(1, std::memory_order_relaxed);
        return Status::kFull;
    }

    /// Consumer only. kNotReady if the queue is empty (value untouched).
    Status pop(T& value) { return queue_.pop(value) ? Status::kOk : Status::kNotReady; }

    /// Consumer only: values waiting, at least.
    std::size_t size() const { return queue_.read_available(); }

    /// Any thread: values rejected since construction.
    std::uint64_t rejected() const { return rejected_.load(std::memory_order_relaxed); }

private:
    boost::lockfree::spsc_queue<T, boost::lockfree::capacity<N>> queue_;
    std::atomic<std::uint64_t> rejected_{0};
};

}  // namespace facet
