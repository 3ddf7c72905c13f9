// SPDX-License-Identifier: BSD-2-Clause
// A vector whose storage is part of the object: at most N elements, no heap.
#pragma once

#include <boost/container/static_vector.hpp>
#include <cstddef>
#include <utility>

#include "platform/base/assert.h"
#include "platform/base/status.h"

namespace facet {

/// Up to N elements in place, in order of insertion; a narrow front of boost::container::static_vector.
/// When full: try_push_back rejects (kFull, nothing changed); push_back is for callers that know there is room and
/// aborts. Elements are contiguous, so it converts to std::span: functions take spans, not FixedVectors.
/// Thread-bound. No heap (beyond what T itself does).
template <class T, std::size_t N>
class FixedVector {
public:
    using value_type = T;
    using iterator = T*;

    static constexpr std::size_t capacity() { return N; }
    std::size_t size() const { return items_.size(); }
    bool empty() const { return items_.empty(); }
    bool full() const { return items_.size() == N; }

    T* data() { return items_.data(); }
    const T* data() const { return items_.data(); }
    T* begin() { return data(); }
    T* end() { return data() + size(); }
    const T* begin() const { return data(); }
    const T* end() const { return data() + size(); }

    /// Contract: i < size().
    T& operator[](std::size_t i) {
        FACET_ASSERT(i < size());
        return data()[i];
    }
    const T& operator[](std::size_t i) const {
        FACET_ASSERT(i < size());
        return data()[i];
    }
    T& front() { return (*this)[0]; }
    const T& front() const { return (*this)[0]; }
    T& back() { return (*this)[size() - 1]; }
    const T& back() const { return (*this)[size() - 1]; }

    /// Appends, or kFull.
    Status try_push_back(T value) {
        if (full()) {
            return Status::kFull;
        }
        items_.push_back(std::move(value));
        return Status::kOk;
    }
    /// Appends. Contract: !full().
    T& push_back(T value) {
        FACET_ASSERT(!full());
        items_.push_back(std::move(value));
        return items_.back();
    }
    /// Contract: !empty().
    void pop_back() {
        FACET_ASSERT(!empty());
        items_.pop_back();
    }
    /// New elements are value-initialised. Contract: n <= N.
    void resize(std::size_t n) {
        FACET_ASSERT(n <= N);
        items_.resize(n);
    }
    /// Removes element i, keeps the order of the others; O(size). Contract: i < size().
    void erase_at(std::size_t i) {
        FACET_ASSERT(i < size());
        items_.erase(items_.begin() + static_cast<std::ptrdiff_t>(i));
    }
    void clear() { items_.clear(); }

private:
    boost::container::static_vector<T, N> items_;
};

}  // namespace facet
