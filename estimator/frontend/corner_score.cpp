// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/corner_score.h"

#include <algorithm>
#include <cmath>

#include "estimator/frontend/simd.h"
#include "platform/base/assert.h"

namespace facet {
namespace {

constexpr float kScale = 1.0F / (20.0F * 255.0F);

}  // namespace

void CornerScore::configure(int width, int height) {
    width_ = width;
    height_ = height;
    const auto columns = static_cast<std::size_t>(width);
    gu_.assign((kWindow + 1) * columns, 0);
    gv_.assign((kWindow + 1) * columns, 0);
    uu_.assign(columns, 0);
    uv_.assign(columns, 0);
    vv_.assign(columns, 0);
    scores_.assign(columns * static_cast<std::size_t>(height) + simd::kOverread, 0.0F);
}

void CornerScore::gradients(const ImageView& image, int v) {
    const std::uint8_t* const up = image.row(v - 1);
    const std::uint8_t* const at = image.row(v);
    const std::uint8_t* const down = image.row(v + 1);
    const std::size_t first = static_cast<std::size_t>(v % (kWindow + 1)) * static_cast<std::size_t>(width_);
    std::int16_t* const __restrict gu = gu_.data() + first;
    std::int16_t* const __restrict gv = gv_.data() + first;
    for (int u = 1; u < width_ - 1; ++u) {
        gu[u] = static_cast<std::int16_t>((up[u + 1] - up[u - 1]) + 2 * (at[u + 1] - at[u - 1]) +
                                          (down[u + 1] - down[u - 1]));
        gv[u] =
            static_cast<std::int16_t>((down[u - 1] - up[u - 1]) + 2 * (down[u] - up[u]) + (down[u + 1] - up[u + 1]));
    }
}

void CornerScore::slide(int v) {
    const std::size_t in = static_cast<std::size_t>(v % (kWindow + 1)) * static_cast<std::size_t>(width_);
    const std::size_t out = static_cast<std::size_t>((v + 1) % (kWindow + 1)) * static_cast<std::size_t>(width_);
    // None of these overlap, nor do they alias the width; without __restrict the loop would not be vectorized.
    const int width = width_;
    const std::int16_t* const __restrict gu = gu_.data() + in;
    const std::int16_t* const __restrict gv = gv_.data() + in;
    const std::int16_t* const __restrict old_gu = gu_.data() + out;  // kWindow rows up; 0 above the image
    const std::int16_t* const __restrict old_gv = gv_.data() + out;
    std::int32_t* const __restrict uu = uu_.data();
    std::int32_t* const __restrict uv = uv_.data();
    std::int32_t* const __restrict vv = vv_.data();
    for (int u = 1; u < width - 1; ++u) {
        const std::int32_t a = gu[u];
        const std::int32_t b = gv[u];
        const std::int32_t old_a = old_gu[u];
        const std::int32_t old_b = old_gv[u];
        uu[u] += a * a - old_a * old_a;
        uv[u] += a * b - old_a * old_b;
        vv[u] += b * b - old_b * old_b;
    }
}

void CornerScore::finish_row(int v) {
    float* const __restrict out = scores_.data() + static_cast<std::ptrdiff_t>(v) * width_;
    const auto across = [](const std::int32_t* s) { return static_cast<float>(s[-2] + s[-1] + s[0] + s[1] + s[2]); };
    for (int u = kReach; u < width_ - kReach; ++u) {
        const float a = 0.5F * across(uu_.data() + u);
        const float b = across(uv_.data() + u);
        const float c = 0.5F * across(vv_.data() + u);
        out[u] = kScale * kScale * ((a + c) - std::sqrt((a - c) * (a - c) + b * b));
    }
    simd::Floats best = simd::splat(best_);
    for (int u = 0; u + simd::kLanes <= width_; u += simd::kLanes) {
        const simd::Floats s = simd::load(out + u);
        best = s > best ? s : best;
    }
    best_ = std::max(simd::greatest(best), *std::max_element(out + width_ - simd::kLanes, out + width_));
}

void CornerScore::compute(const ImageView& image) {
    FACET_ASSERT(image.width == width_ && image.height == height_ && width_ > 2 * kReach);
    best_ = 0.0F;
    std::fill(gu_.begin(), gu_.end(), std::int16_t{0});
    std::fill(gv_.begin(), gv_.end(), std::int16_t{0});
    std::fill(uu_.begin(), uu_.end(), 0);
    std::fill(uv_.begin(), uv_.end(), 0);
    std::fill(vv_.begin(), vv_.end(), 0);
    for (int v = 1; v < height_ - 1; ++v) {
        gradients(image, v);
        slide(v);
        if (v >= kWindow) {
            finish_row(v - kWindow / 2);
        }
    }
}

}  // namespace facet
