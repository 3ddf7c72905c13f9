// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/image_pyramid.h"

#include <algorithm>

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
    // Weights 1 4 6 4 1 down, then across; the sums stay below 2^16 even after both, rounding included.
    // Local copies and __restrict: writes of bytes may alias anything, even a view's width, and prevent vectorization.
    const ImageView from = level(l - 1);
    const ImageView to = level(l);
    std::uint16_t* const __restrict sums = row_.data() + kReach;
    for (int v = 0; v < to.height; ++v) {
        const std::uint8_t* const r0 = from.row(mirrored(2 * v - 2, from.height));
        const std::uint8_t* const r1 = from.row(mirrored(2 * v - 1, from.height));
        const std::uint8_t* const r2 = from.row(2 * v);
        const std::uint8_t* const r3 = from.row(mirrored(2 * v + 1, from.height));
        const std::uint8_t* const r4 = from.row(mirrored(2 * v + 2, from.height));
        for (int u = 0; u < from.width; ++u) {
            sums[u] = static_cast<std::uint16_t>(r0[u] + r4[u] + 4 * (r1[u] + r3[u]) + 6 * r2[u]);
        }
        for (int k = 1; k <= kReach; ++k) {
            sums[-k] = sums[k];
            sums[from.width - 1 + k] = sums[from.width - 1 - k];
        }
        std::uint8_t* const __restrict out = buffers_[static_cast<std::size_t>(l)].data() + v * to.stride;
        for (int u = 0; u < to.width; ++u) {
            const std::uint16_t* const s = sums + 2 * u;
            const auto total = static_cast<std::uint16_t>(s[-2] + s[2] + 4 * (s[-1] + s[1]) + 6 * s[0] + 128);
            out[u] = static_cast<std::uint8_t>(total >> 8);
        }
    }
}

void ImagePyramid::pair_rows(int l) {
    const ImageView image = level(l);
    std::uint16_t* out = pair_buffers_[static_cast<std::size_t>(l)].data();
    for (int v = 0; v < image.height; ++v, out += image.width) {
        const std::uint8_t* const upper = image.row(v);
        const std::uint8_t* const lower = image.row(std::min(v + 1, image.height - 1));
        for (int u = 0; u < image.width; ++u) {
            out[u] = static_cast<std::uint16_t>(upper[u] | lower[u] << 8);
        }
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
