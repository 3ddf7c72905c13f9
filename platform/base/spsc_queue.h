// SPDX-License-Identifier: BSD-2-Clause
// The bounded, lock-free way from one sensor thread to the estimator thread.
#pragma once

#include <atomic>
#include <boost/lockfree/policies.hpp>
#include <boost/lockfree/spsc_queue.hpp>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <utility>

#include "platform/base/status.h"

namespace facet {

/// A wait-free queue of at most N values between one producer thread and one consumer thread, over
/// boost::lockfree::spsc_queue with storage in place.
/// When full: push rejects (kFull, the queue is unchanged) and counts it in rejected().
/// T is moved, or copied if it is pushed as an lvalue. Values still waiting are destroyed with the queue.
/// Thread-safe for exactly one pushing and one popping thread. No heap (beyond what T itself does).
template <class T, std::size_t N>
class SpscQueue {
public:
    SpscQueue() = default;
    SpscQueue(const SpscQueue&) = delete;
    SpscQueue& operator=(const SpscQueue&) = delete;
    // Boost's queue with storage in place leaves out the destructors of what it holds.
    ~SpscQueue() {
        (void)queue_.consume_all([](T&) {});
    }

    static constexpr std::size_t capacity() { return N; }

    /// Producer only. kFull if the consumer has fallen behind (value untouched).
    Status push(const T& value) { return counted(queue_.push(value)); }
    Status push(T&& value) {
        // Boost 1.74 moves a value in only as part of a range.
        const std::move_iterator<T*> begin(&value);
        return counted(queue_.push(begin, std::next(begin)) != begin);
    }

    /// Consumer only. kNotReady if the queue is empty (value untouched).
    Status pop(T& value) {
        const auto take = [&value](T& front) { value = std::move(front); };
        return queue_.consume_one(take) ? Status::kOk : Status::kNotReady;
    }

    /// Consumer only: values waiting, at least.
    std::size_t size() const { return queue_.read_available(); }

    /// Any thread: values rejected since construction.
    std::uint64_t rejected() const { return rejected_.load(std::memory_order_relaxed); }

private:
    Status counted(bool is_pushed) {
        if (is_pushed) {
            return Status::kOk;
        }
        rejected_.fetch_add(1, std::memory_order_relaxed);
        return Status::kFull;
    }

    boost::lockfree::spsc_queue<T, boost::lockfree::capacity<N>> queue_;
    std::atomic<std::uint64_t> rejected_{0};
};

}  // namespace facet
