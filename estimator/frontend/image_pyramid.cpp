// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/image_pyramid.h"

#include <algorithm>

#include "estimator/frontend/pixel_rows.h"
#include "estimator/frontend/simd.h"
#include "platform/base/assert.h"

namespace facet {
namespace {

constexpr int kMinSide = 16;
constexpr int kReach = 2;  // of the filter

/// Index in [0, size) of a row up to kReach outside: mirrored about the first or last one.
int mirrored(int i, int size) { return i < 0 ? -i : (i >= size ? 2 * size - 2 - i : i); }

}  // namespace

Status ImagePyramid::configure(int width, int height, int levels) {
    if (levels < 1 || levels > kMaxLevels || width > simd::kMaxSide || height > simd::kMaxSide ||
        (width >> (levels - 1)) < kMinSide || (height >> (levels - 1)) < kMinSide) {
        return Status::kInvalidArgument;
    }
    levels_ = levels;
    row_.assign(static_cast<std::size_t>(width + 2 * kReach + 1), 0);
    for (int l = 0; l < levels; ++l) {
        auto& buffer = buffers_[static_cast<std::size_t>(l)];
        buffer.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) + simd::kOverread, 0);
        views_[static_cast<std::size_t>(l)] = {buffer.data(), width, height, width};
        auto& pairs = pair_buffers_[static_cast<std::size_t>(l)];
        pairs.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0);
        pairs_[static_cast<std::size_t>(l)] = {pairs.data(), width, height, width};
        width = (width + 1) / 2;
        height = (height + 1) / 2;
    }
    return Status::kOk;
}

void ImagePyramid::halve(int l) {
    // Down, then across; the sums stay below 2^16 even after both, rounding included.
    const ImageView from = level(l - 1);
    const ImageView to = level(l);
    std::uint16_t* const sums = row_.data() + kReach;
    for (int v = 0; v < to.height; ++v) {
        pixel_rows::blur_down(
            {from.row(mirrored(2 * v - 2, from.height)), from.row(mirrored(2 * v - 1, from.height)), from.row(2 * v),
             from.row(mirrored(2 * v + 1, from.height)), from.row(mirrored(2 * v + 2, from.height))},
            from.width, sums);
        for (int k = 1; k <= kReach; ++k) {
            sums[-k] = sums[k];
            sums[from.width - 1 + k] = sums[from.width - 1 - k];
        }
        pixel_rows::blur_across(sums, to.width, buffers_[static_cast<std::size_t>(l)].data() + v * to.stride);
    }
}

void ImagePyramid::pair_rows(int l) {
    const ImageView image = level(l);
    std::uint16_t* out = pair_buffers_[static_cast<std::size_t>(l)].data();
    for (int v = 0; v < image.height; ++v, out += image.width) {
        pixel_rows::pair(image.row(v), image.row(std::min(v + 1, image.height - 1)), image.width, out);
    }
}

void ImagePyramid::build(const ImageView& image) {
    FACET_ASSERT(levels_ > 0 && image.width == views_[0].width && image.height == views_[0].height);
    for (int v = 0; v < image.height; ++v) {
        std::copy_n(image.row(v), image.width, buffers_[0].data() + v * views_[0].stride);
    }
    pair_rows(0);
    for (int l = 1; l < levels_; ++l) {
        halve(l);
        pair_rows(l);
    }
}

}  // namespace facet
