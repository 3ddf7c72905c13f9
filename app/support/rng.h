// SPDX-License-Identifier: BSD-2-Clause
// Counter-based random numbers: a value depends only on its seed and its place, never on the order of calls.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "platform/base/hash64.h"

namespace facet {

/// 32 random bits from 32 (two multiply-xorshift rounds), for the inner loops. Bijective.
constexpr std::uint32_t mix32(std::uint32_t x) {
    x = (x ^ (x >> 16)) * 0x85ebca6bU;
    x = (x ^ (x >> 13)) * 0xc2b2ae35U;
    return x ^ (x >> 16);
}

/// Nearly standard normal from 64 bits: the sum of four 16-bit uniforms, scaled to variance 1. Bounded by +-3.46, which
/// pixel noise does not mind; cheap. Reentrant.
constexpr float irwin_hall_normal(std::uint64_t bits) {
    const auto sum =
        static_cast<float>((bits & 0xffffU) + ((bits >> 16) & 0xffffU) + ((bits >> 32) & 0xffffU) + (bits >> 48));
    return (sum * (1.0F / 65536.0F) - 2.0F) * 1.7320508F;
}

/// A sequence of random numbers, one per (seed, purpose). Not for pixels. Thread-bound. No heap.
class RandomStream {
public:
    RandomStream(std::uint64_t seed, std::uint64_t purpose) : key_(hash64(seed, purpose)) {}

    std::uint64_t bits() { return hash64(key_, counter_++); }
    /// In [0, 1).
    double uniform() { return static_cast<double>(bits() >> 11) * 0x1.0p-53; }
    double uniform(double low, double high) { return low + (high - low) * uniform(); }
    /// In [0, count).
    int index(int count) { return static_cast<int>(uniform() * count); }
    /// Standard normal (Box-Muller).
    double normal() {
        const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
        return radius * std::cos(2.0 * std::numbers::pi * uniform());
    }

private:
    std::uint64_t key_;
    std::uint64_t counter_ = 0;
};

}  // namespace facet
