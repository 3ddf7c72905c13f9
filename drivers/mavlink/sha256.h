// SPDX-License-Identifier: BSD-2-Clause
// SHA-256, for the signatures of MAVLink.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace facet {

using Sha256Digest = std::array<std::uint8_t, 32>;

/// Digest of bytes that come in pieces [FIPS 180-4]. Usage: add(...); add(...); digest(). Thread-bound. No heap.
class Sha256 {
public:
    void add(std::span<const std::uint8_t> bytes);
    /// Of all that was added. Nothing may follow.
    Sha256Digest digest();

private:
    void take_block();

    std::array<std::uint32_t, 8> state_{0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                        0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
    std::array<std::uint8_t, 64> block_{};
    std::size_t filled_ = 0;
    std::uint64_t bytes_ = 0;
};

}  // namespace facet
