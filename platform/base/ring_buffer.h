// SPDX-License-Identifier: BSD-2-Clause
// The newest N values, oldest first.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "platform/base/assert.h"

namespace facet {

/// A queue of at most N values in place, index 0 the oldest.
/// When full: push drops the oldest and counts it in dropped(). T must be default-constructible; a popped value stays
/// in its cell until it is overwritten. Thread-bound. No heap (beyond what T itself does).
template <class T, std::size_t N>
class RingBuffer {
    static_assert(N > 0);

public:
    static constexpr std::size_t capacity() { return N; }
    std::size_t size() const { return size_; }
    bool empty() const { return size_ == 0; }
    bool full() const { return size_ == N; }
    /// Values dropped by push since construction or clear.
    std::uint64_t dropped() const { return dropped_; }

    void push(T value) {
        if (full()) {
            pop_front();
            ++dropped_;
        }
        items_[cell(size_)] = std::move(value);
        ++size_;
    }

    /// Forgets the n oldest. Contract: n <= size().
    void pop_front(std::size_t n = 1) {
        FACET_ASSERT(n <= size_);
        first_ = cell(n);
        size_ -= n;
    }

    /// Contract: i < size().
    T& operator[](std::size_t i) {
        FACET_ASSERT(i < size_);
        return items_[cell(i)];
    }
    const T& operator[](std::size_t i) const {
        FACET_ASSERT(i < size_);
        return items_[cell(i)];
    }
    const T& front() const { return (*this)[0]; }
    const T& back() const { return (*this)[size_ - 1]; }

    void clear() {
        first_ = 0;
        size_ = 0;
        dropped_ = 0;
    }

private:
    /// Cell of index i <= N.
    std::size_t cell(std::size_t i) const {
        const std::size_t k = first_ + i;
        return k < N ? k : k - N;
    }

    std::array<T, N> items_{};
    std::size_t first_ = 0;
    std::size_t size_ = 0;
    std::uint64_t dropped_ = 0;
};

}  // namespace facet
