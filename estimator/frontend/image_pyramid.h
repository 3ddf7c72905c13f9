// SPDX-License-Identifier: BSD-2-Clause
// A Gaussian pyramid of a grey image in buffers of its own.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "estimator/frontend/row_pairs.h"
#include "platform/base/image_view.h"
#include "platform/base/status.h"

namespace facet {

/// Level l is half the size of level l-1: pixel (u, v) of level l lies at (2 u, 2 v) of level l-1 (5x5 binomial filter
/// before decimation, mirrored at the border). Level 0 is the image itself: smoothing it first, by 3x3 or 5x5, was
/// tried against the bias of bilinear interpolation, but the second rounding to 8 bits and the lost contrast cost more
/// than it gained. The buffers extend beyond the pixels, so that whole vectors may be read at the last ones.
/// Heap: in configure() only. Thread-bound.
class ImagePyramid {
public:
    static constexpr int kMaxLevels = 6;

    /// Allocates the buffers.
    /// @return kInvalidArgument unless 1 <= levels <= 6, the coarsest level is at least 16 px wide and high, and the
    ///         finest at most simd::kMaxSide.
    Status configure(int width, int height, int levels);

    /// Copies and filters an image of the configured size (FACET_ASSERT).
    void build(const ImageView& image);

    int levels() const { return levels_; }
    const ImageView& level(int l) const { return views_[static_cast<std::size_t>(l)]; }

    /// The same level in the form that interpolation reads.
    const RowPairs& pairs(int l) const { return pairs_[static_cast<std::size_t>(l)]; }

private:
    void halve(int level);
    void pair_rows(int level);

    int levels_ = 0;
    std::array<std::vector<std::uint8_t>, kMaxLevels> buffers_;
    std::array<ImageView, kMaxLevels> views_;
    std::array<std::vector<std::uint16_t>, kMaxLevels> pair_buffers_;
    std::array<RowPairs, kMaxLevels> pairs_;
    std::vector<std::uint16_t> row_;  ///< filtered down the columns, with the mirrored border
};

}  // namespace facet
