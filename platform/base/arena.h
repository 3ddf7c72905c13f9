// SPDX-License-Identifier: BSD-2-Clause
// Scratch memory: a bump allocator over storage that the caller owns.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <type_traits>

#include "platform/base/assert.h"

namespace facet {

/// Hands out pieces of one block of memory in order, and takes them back all at once. Usage:
///   Arena arena(storage);
///   {
///       const Arena::Scope scope(arena);  // everything below is given back at the brace
///       std::span<double> h = arena.make_array<double>(n * n);
///       if (h.empty()) return Status::kFull;
///   }
/// When full: allocate returns nullptr, make_array an empty span; nothing changed. Nothing is ever destroyed, so only
/// trivially destructible types are allowed. Thread-bound. No heap.
class Arena {
public:
    /// A position to go back to.
    using Mark = std::size_t;

    explicit Arena(std::span<std::byte> storage) : storage_(storage) {}
    Arena(const Arena&) = delete;
    Arena& operator=(const Arena&) = delete;

    /// @param bytes      size, may be 0 (then the pointer must not be read through)
    /// @param alignment  a power of two
    /// @return nullptr if the block has no room left.
    [[nodiscard]] void* allocate(std::size_t bytes, std::size_t alignment) {
        FACET_ASSERT(std::has_single_bit(alignment));
        const auto address = reinterpret_cast<std::uintptr_t>(storage_.data()) + used_;
        const std::size_t padding = (alignment - (address & (alignment - 1))) & (alignment - 1);
        const std::size_t room = storage_.size() - used_;
        if (padding > room || bytes > room - padding) {
            return nullptr;
        }
        void* const piece = storage_.data() + used_ + padding;
        used_ += padding + bytes;
        high_water_ = used_ > high_water_ ? used_ : high_water_;
        return piece;
    }

    /// n value-initialised elements, aligned for T and at least to `alignment` (32: one AVX register, for Eigen's
    /// aligned maps). Empty if the block has no room left, or if n is 0.
    template <class T>
    [[nodiscard]] std::span<T> make_array(std::size_t n, std::size_t alignment = 32) {
        static_assert(std::is_trivially_destructible_v<T>, "the arena destroys nothing");
        if (n > storage_.size() / sizeof(T)) {
            return {};
        }
        void* const piece = allocate(n * sizeof(T), alignof(T) > alignment ? alignof(T) : alignment);
        if (piece == nullptr) {
            return {};
        }
        T* const first = static_cast<T*>(piece);
        std::uninitialized_value_construct_n(first, n);
        return {first, n};
    }

    Mark mark() const { return used_; }
    /// Gives back everything handed out since `mark`. Contract: `mark` came from this arena and is not ahead of it.
    void rewind(Mark mark) {
        FACET_ASSERT(mark <= used_);
        used_ = mark;
    }
    void clear() { used_ = 0; }

    std::size_t used() const { return used_; }
    std::size_t capacity() const { return storage_.size(); }
    /// Most bytes ever in use, padding included.
    std::size_t high_water() const { return high_water_; }

    /// Rewinds at the end of its life to where the arena was at its beginning.
    class Scope {
    public:
        explicit Scope(Arena& arena) : arena_(arena), mark_(arena.mark()) {}
        ~Scope() { arena_.rewind(mark_); }
        Scope(const Scope&) = delete;
        Scope& operator=(const Scope&) = delete;

    private:
        Arena& arena_;
        Mark mark_;
    };

private:
    std::span<std::byte> storage_;
    std::size_t used_ = 0;
    std::size_t high_water_ = 0;
};

}  // namespace facet
