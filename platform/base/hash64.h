// SPDX-License-Identifier: BSD-2-Clause
// Well mixed bits that depend on a seed and a place alone.
#pragma once

#include <cstdint>

namespace facet {

/// Mixes 64 bits: the finaliser of SplitMix64 (Steele, Lea, Flood, OOPSLA 2014). Bijective. Reentrant.
constexpr std::uint64_t mix64(std::uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
    return x ^ (x >> 31);
}

/// 64 random bits for a place (a, b, c) under a seed.
constexpr std::uint64_t hash64(std::uint64_t seed, std::uint64_t a, std::uint64_t b = 0, std::uint64_t c = 0) {
    constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15ULL;
    std::uint64_t x = mix64(seed + kGolden);
    x = mix64(x + kGolden * (a + 1));
    x = mix64(x + kGolden * (b + 1));
    return mix64(x + kGolden * (c + 1));
}

}  // namespace facet
