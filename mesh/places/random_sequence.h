// SPDX-License-Identifier: BSD-2-Clause
// Numbers that look random and are the same everywhere.
#pragma once

#include <cstddef>
#include <cstdint>

#include "platform/base/hash64.h"

namespace facet {

/// splitmix64 [Steele14]. Reentrant.
class RandomSequence {
public:
    constexpr explicit RandomSequence(std::uint64_t seed) : state_(seed) {}

    constexpr std::uint64_t next() {
        state_ += 0x9E3779B97F4A7C15ULL;
        return mix64(state_);
    }
    /// Below a bound.
    constexpr std::size_t index(std::size_t bound) { return static_cast<std::size_t>(next() % bound); }

private:
    std::uint64_t state_;
};

}  // namespace facet
