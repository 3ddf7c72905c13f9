// SPDX-License-Identifier: BSD-2-Clause
// Hashes of 64 bits: well mixed ones of a seed and a place, and a checksum of bytes.
#pragma once

#include <cstdint>
#include <string_view>

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

/// FNV-1a: tells accidental changes of a text or a file, not deliberate ones. Reentrant.
constexpr std::uint64_t fnv1a(std::string_view bytes) {
    std::uint64_t hash = 0xcbf29ce484222325ULL;
    for (const char c : bytes) {
        hash = (hash ^ static_cast<std::uint8_t>(c)) * 0x100000001b3ULL;
    }
    return hash;
}

}  // namespace facet
