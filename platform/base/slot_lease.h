// SPDX-License-Identifier: BSD-2-Clause
// Slots that one thread lends out and any thread gives back: whoever holds a lease may use its slot.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <utility>

#include "platform/base/assert.h"

namespace facet {

template <std::size_t N>
class SlotLender;

/// The right to use one slot of a SlotLender. Move-only: the slot is free again when the last lease of it ends, which
/// is when the lease is destroyed, assigned to, or ended by release(). A default-constructed or moved-from lease holds
/// nothing. Thread-bound; a lease may be handed to another thread and end there. No heap.
class SlotLease {
public:
    SlotLease() = default;
    SlotLease(SlotLease&& other) noexcept
        : leases_(std::exchange(other.leases_, nullptr)), slot_(std::exchange(other.slot_, -1)) {}
    SlotLease& operator=(SlotLease&& other) noexcept {
        if (this != &other) {
            release();
            leases_ = std::exchange(other.leases_, nullptr);
            slot_ = std::exchange(other.slot_, -1);
        }
        return *this;
    }
    SlotLease(const SlotLease&) = delete;
    SlotLease& operator=(const SlotLease&) = delete;
    ~SlotLease() { release(); }

    bool held() const { return leases_ != nullptr; }
    /// Number of the slot, below the lender's N; -1 if nothing is held.
    int slot() const { return slot_; }

    /// Another lease of the same slot, for a second user of its content; empty if nothing is held.
    SlotLease share() const {
        if (held()) {
            leases_->fetch_add(1, std::memory_order_relaxed);
        }
        return SlotLease(leases_, slot_);
    }

    /// Ends this lease early; nothing if none is held.
    void release() {
        if (held()) {
            // What the holder has read happens before the lender writes the slot's next content.
            leases_->fetch_sub(1, std::memory_order_release);
            leases_ = nullptr;
            slot_ = -1;
        }
    }

private:
    template <std::size_t N>
    friend class SlotLender;

    SlotLease(std::atomic<int>* leases, int slot) : leases_(leases), slot_(slot) {}

    std::atomic<int>* leases_ = nullptr;  ///< the lender's count of the slot's leases
    int slot_ = -1;
};

/// N slots, numbered from 0. It keeps only which are lent; what is in them belongs to the owner of the lender.
/// When all are lent: take() returns an empty lease.
/// take() is for one thread; leases may end on others. Contract: leases end before their lender does. No heap.
template <std::size_t N>
class SlotLender {
    static_assert(N > 0);

public:
    SlotLender() = default;
    SlotLender(const SlotLender&) = delete;
    SlotLender& operator=(const SlotLender&) = delete;
    ~SlotLender() { FACET_ASSERT(lent() == 0); }

    static constexpr std::size_t capacity() { return N; }

    /// Lends the free slot of the lowest number.
    SlotLease take() {
        for (std::size_t i = 0; i < N; ++i) {
            if (leases_[i].load(std::memory_order_acquire) == 0) {
                leases_[i].store(1, std::memory_order_relaxed);
                return SlotLease(&leases_[i], static_cast<int>(i));
            }
        }
        return {};
    }

    /// Slots lent at the moment; any thread.
    std::size_t lent() const {
        std::size_t count = 0;
        for (const std::atomic<int>& leases : leases_) {
            count += leases.load(std::memory_order_acquire) == 0 ? 0 : 1;
        }
        return count;
    }

private:
    std::array<std::atomic<int>, N> leases_{};  ///< of each slot
};

}  // namespace facet
