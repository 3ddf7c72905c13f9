// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/dot_filter.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "platform/base/assert.h"

namespace facet {
namespace {

constexpr int kReach = DotFilter::kSide_px / 2;
// Of 2500 dots in rendered images 98 % lose more of their contrast than this, of corners of four sequences and two
// rendered rooms 5 to 21 %.
constexpr double kDotShare = 0.7;
constexpr int kBesideDot_px = 4;
// Of images with noise of 2: five standard deviations and more.
constexpr int kNoise = 16;

struct Least {
    std::uint8_t operator()(std::uint8_t a, std::uint8_t b) const { return std::min(a, b); }
};
struct Largest {
    std::uint8_t operator()(std::uint8_t a, std::uint8_t b) const { return std::max(a, b); }
};

/// out[u] = choice of in[u - 2 .. u + 2], with the border repeated.
template <class Choice>
void choose_along(const std::uint8_t* __restrict in, int width, std::uint8_t* __restrict out) {
    const Choice choose;
    for (int u = kReach; u < width - kReach; ++u) {
        out[u] = choose(choose(choose(in[u - 2], in[u - 1]), choose(in[u + 1], in[u + 2])), in[u]);
    }
    for (const int u : {0, 1, width - 2, width - 1}) {
        out[u] = in[u];
        for (int k = -kReach; k <= kReach; ++k) {
            out[u] = choose(out[u], in[std::clamp(u + k, 0, width - 1)]);
        }
    }
}

/// The same down the columns. @param row  row(k): row v + k, of the border if there is none
template <class Choice, class Row>
void choose_down(const Row& row, int width, std::uint8_t* __restrict out) {
    const Choice choose;
    const std::uint8_t* const r0 = row(-2);
    const std::uint8_t* const r1 = row(-1);
    const std::uint8_t* const r2 = row(0);
    const std::uint8_t* const r3 = row(1);
    const std::uint8_t* const r4 = row(2);
    for (int u = 0; u < width; ++u) {
        out[u] = choose(choose(choose(r0[u], r1[u]), choose(r3[u], r4[u])), r2[u]);
    }
}

}  // namespace

void DotFilter::configure(int width, int height) {
    FACET_ASSERT(width >= kSide_px && height >= kSide_px);
    width_ = width;
    height_ = height;
    const auto size = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    opened_ = std::make_unique_for_overwrite<std::uint8_t[]>(size);
    rows_ = std::make_unique_for_overwrite<std::uint8_t[]>(static_cast<std::size_t>(width) * (2 * kSide_px + 1));
}

/// Row by row: the least values along it, and down the columns two rows later; of those the largest along them, and
/// down the columns two rows later again.
ImageView DotFilter::open(const ImageView& image) {
    const int width = image.width;
    const int height = image.height;
    FACET_ASSERT(width >= kSide_px && height >= kSide_px && width <= width_ && height <= height_);
    const auto row_at = [width](std::uint8_t* begin, int v) { return begin + static_cast<std::ptrdiff_t>(v) * width; };
    const auto least = [&](int v) { return row_at(rows_.get(), v % kSide_px); };
    const auto largest = [&](int v) { return row_at(rows_.get(), kSide_px + v % kSide_px); };
    std::uint8_t* const eroded = row_at(rows_.get(), 2 * kSide_px);
    for (int v = 0; v < height + 2 * kReach; ++v) {
        if (v < height) {
            choose_along<Least>(image.row(v), width, least(v));
        }
        const int e = v - kReach;
        if (e >= 0 && e < height) {
            choose_down<Least>([&](int k) { return least(std::clamp(e + k, 0, height - 1)); }, width, eroded);
            choose_along<Largest>(eroded, width, largest(e));
        }
        const int o = e - kReach;
        if (o >= 0) {
            choose_down<Largest>([&](int k) { return largest(std::clamp(o + k, 0, height - 1)); }, width,
                                 row_at(opened_.get(), o));
        }
    }
    return {opened_.get(), width, height, width};
}

bool DotFilter::is_dot(const ImageView& image, const ImageView& opened, const Eigen::Vector2d& uv) {
    const int u0 = static_cast<int>(std::lround(uv.x()));
    const int v0 = static_cast<int>(std::lround(uv.y()));
    int bright = 0;
    int taken = 0;
    int dark = 255;
    for (int v = std::max(0, v0 - kBesideDot_px); v <= std::min(image.height - 1, v0 + kBesideDot_px); ++v) {
        for (int u = std::max(0, u0 - kBesideDot_px); u <= std::min(image.width - 1, u0 + kBesideDot_px); ++u) {
            const int grey = image.row(v)[u];
            dark = std::min(dark, grey);
            if (std::abs(u - u0) <= 1 && std::abs(v - v0) <= 1) {
                bright = std::max(bright, grey);
                taken = std::max(taken, grey - opened.row(v)[u]);
            }
        }
    }
    return taken > kDotShare * (bright - dark);
}

double DotFilter::share(const ImageView& image, const ImageView& opened) {
    std::ptrdiff_t taken = 0;
    for (int v = 0; v < image.height; ++v) {
        const std::uint8_t* const a = image.row(v);
        const std::uint8_t* const b = opened.row(v);
        for (int u = 0; u < image.width; ++u) {
            taken += a[u] - b[u] > kNoise ? 1 : 0;
        }
    }
    return static_cast<double>(taken) / (static_cast<double>(image.width) * image.height);
}

}  // namespace facet
