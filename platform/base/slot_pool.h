// SPDX-License-Identifier: BSD-2-Clause
// Values found by typed id, in slots that do not move.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "platform/base/assert.h"
#include "platform/base/result.h"
#include "platform/base/typed_id.h"

namespace facet {

/// Up to N values of type T, each under an id of type Id (a TypedId). A value keeps its slot, and so its address, until
/// it is erased; slots are used again. Lookup, insertion and removal in constant expected time, by a hash table with
/// linear probing that is at most half full. Walking slots 0..capacity()-1 where used() holds visits all values in an
/// order that depends only on the calls made: deterministic.
/// When full: insert rejects (kFull, nothing changed). Thread-bound. No heap (beyond what T itself does).
template <class Id, class T, std::size_t N>
class SlotPool {
    static_assert(N > 0 && N < 0x40000000U);

public:
    using Slot = std::uint32_t;

    SlotPool() { clear(); }

    static constexpr std::size_t capacity() { return N; }
    std::size_t size() const { return size_; }
    bool empty() const { return size_ == 0; }
    bool full() const { return size_ == N; }

    /// A slot for a new id, its value freshly made by T().
    /// @return kInvalidArgument if the id is invalid or already there; kFull if no slot is left.
    Result<Slot> insert(Id id) {
        if (!id.valid() || find_bucket(id) != kNone) {
            return Status::kInvalidArgument;
        }
        if (full()) {
            return Status::kFull;
        }
        const Slot slot = free_[N - 1 - size_];
        ++size_;
        ids_[slot] = id;
        std::destroy_at(&values_[slot]);
        std::construct_at(&values_[slot]);
        std::uint32_t bucket = home(id);
        while (buckets_[bucket] != kNone) {
            bucket = next(bucket);
        }
        buckets_[bucket] = slot;
        return slot;
    }

    /// The id's slot, or kNotFound.
    Result<Slot> find(Id id) const {
        const std::uint32_t bucket = find_bucket(id);
        if (bucket == kNone) {
            return Status::kNotFound;
        }
        return buckets_[bucket];
    }

    /// Frees the id's slot, or kNotFound. The value is destroyed when its slot is used again.
    Status erase(Id id) {
        std::uint32_t hole = find_bucket(id);
        if (hole == kNone) {
            return Status::kNotFound;
        }
        const Slot slot = buckets_[hole];
        ids_[slot] = Id{};
        --size_;
        free_[N - 1 - size_] = slot;
        // Close the gap: move back every later entry of the run whose home bucket does not lie behind the hole.
        for (std::uint32_t b = next(hole); buckets_[b] != kNone; b = next(b)) {
            const std::uint32_t reach = (b - home(ids_[buckets_[b]])) & kMask;
            if (reach >= ((b - hole) & kMask)) {
                buckets_[hole] = buckets_[b];
                hole = b;
            }
        }
        buckets_[hole] = kNone;
        return Status::kOk;
    }

    bool used(Slot slot) const { return slot < N && ids_[slot].valid(); }
    /// Id in a slot; invalid if the slot is free. Contract: slot < N.
    Id id(Slot slot) const {
        FACET_ASSERT(slot < N);
        return ids_[slot];
    }
    /// Contract: used(slot).
    T& operator[](Slot slot) {
        FACET_ASSERT(used(slot));
        return values_[slot];
    }
    const T& operator[](Slot slot) const {
        FACET_ASSERT(used(slot));
        return values_[slot];
    }

    void clear() {
        ids_.fill(Id{});
        buckets_.fill(kNone);
        for (std::size_t i = 0; i < N; ++i) {
            free_[i] = static_cast<Slot>(N - 1 - i);
        }
        size_ = 0;
    }

private:
    static constexpr std::uint32_t kNone = 0xffffffffU;
    static constexpr std::uint32_t kBuckets = std::bit_ceil(static_cast<std::uint32_t>(2 * N));
    static constexpr std::uint32_t kMask = kBuckets - 1;

    /// Fibonacci hashing: ids come in runs, the multiplication by 2^32 / golden ratio spreads them.
    static constexpr std::uint32_t home(Id id) { return ((id.value * 2654435769U) >> 7) & kMask; }
    static constexpr std::uint32_t next(std::uint32_t bucket) { return (bucket + 1) & kMask; }

    std::uint32_t find_bucket(Id id) const {
        if (!id.valid()) {
            return kNone;
        }
        std::uint32_t bucket = home(id);
        while (buckets_[bucket] != kNone) {
            if (ids_[buckets_[bucket]] == id) {
                return bucket;
            }
            bucket = next(bucket);
        }
        return kNone;
    }

    std::array<T, N> values_{};
    std::array<Id, N> ids_;
    std::array<Slot, kBuckets> buckets_;  ///< slot of the entry, or kNone
    std::array<Slot, N> free_;            ///< stack of free slots; the top is free_[N - 1 - size_]
    std::size_t size_ = 0;
};

}  // namespace facet
