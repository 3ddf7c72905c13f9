// SPDX-License-Identifier: BSD-2-Clause
// Which rows of the left and the right camera's lists are one frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "platform/base/timestamp.h"

namespace facet {

/// The rows that make a frame.
struct StampPair {
    enum class Kind : std::uint8_t {
        kTogether,   ///< within the tolerance
        kApart,      ///< nearest to each other, but not exposed together
        kLeftOnly,   ///< no right row belongs to the left one
        kRightOnly,  ///< no left row belongs to the right one
        kSurplus,    ///< likewise, and it lies within half a period of a left row, which has another one
    };
    static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
    Kind kind = Kind::kLeftOnly;
    std::size_t left = kNone;   ///< index of the row
    std::size_t right = kNone;  ///< likewise
};

/// Pairs rows whose stamps differ by `tolerance` at most, then those left over with the nearest row left over of the
/// other camera within half the left camera's period (the median spacing). In order of stamps: the left row's, or the
/// right one's where there is no left one. Reentrant. Heap.
/// @param left, right  strictly increasing
std::vector<StampPair> pair_stamps(std::span<const Timestamp> left, std::span<const Timestamp> right,
                                   Duration tolerance);

/// By how much the right stamps of such pairs lie after the left ones.
struct StampSkew {
    std::size_t count = 0;
    Duration median;
    Duration least;
    Duration most;
};
/// @param skews  of each pair; reordered
StampSkew summarize_skews(std::span<Duration> skews);

}  // namespace facet
