// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/pixel_mask.h"

#include <algorithm>
#include <cmath>

#include "platform/base/assert.h"

namespace facet {

void PixelMask::configure(int width, int height) {
    width_ = width;
    height_ = height;
    columns_ = (width + kBlock_px - 1) / kBlock_px;
    const int rows = (height + kBlock_px - 1) / kBlock_px;
    drawn_.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), false);
    has_drawing_ = false;
    blocks_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows), {});
    last_until_ = 0;
}

Status PixelMask::draw(const ImageView& drawn) {
    if (drawn.empty()) {
        std::fill(drawn_.begin(), drawn_.end(), false);
        has_drawing_ = false;
        return Status::kOk;
    }
    if (drawn.width != width_ || drawn.height != height_ || drawn.stride < drawn.width) {
        return Status::kInvalidArgument;
    }
    for (int v = 0; v < height_; ++v) {
        const std::uint8_t* const row = drawn.row(v);
        std::transform(row, row + width_, drawn_.begin() + static_cast<std::ptrdiff_t>(v) * width_,
                       [](std::uint8_t pixel) { return pixel == 0; });
    }
    has_drawing_ = true;
    return Status::kOk;
}

void PixelMask::forget() {
    std::fill(blocks_.begin(), blocks_.end(), Block{});
    last_until_ = 0;
}

std::size_t PixelMask::block_of(int u, int v) const {
    return static_cast<std::size_t>(v / kBlock_px) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(u / kBlock_px);
}

Eigen::Vector2i PixelMask::pixel_of(const Eigen::Vector2d& uv) const {
    return {std::clamp(static_cast<int>(std::lround(uv.x())), 0, width_ - 1),
            std::clamp(static_cast<int>(std::lround(uv.y())), 0, height_ - 1)};
}

void PixelMask::cover(const Eigen::Vector2d& uv, Timestamp now) { add(uv, now, kStrikes); }

void PixelMask::suspect(const Eigen::Vector2d& uv, Timestamp now) { add(uv, now, 1); }

void PixelMask::add(const Eigen::Vector2d& uv, Timestamp now, int strikes) {
    // The blocks of the grid that one around the pixel would touch: up to four.
    last_until_ = (now + Duration::from_seconds(kMemory_s)).ns;
    constexpr double kHalf = 0.5 * kBlock_px;
    const Eigen::Vector2i first = pixel_of(uv - Eigen::Vector2d(kHalf, kHalf));
    const Eigen::Vector2i last = pixel_of(uv + Eigen::Vector2d(kHalf, kHalf));
    for (int v = first.y() / kBlock_px; v <= last.y() / kBlock_px; ++v) {
        for (int u = first.x() / kBlock_px; u <= last.x() / kBlock_px; ++u) {
            Block& block = blocks_[block_of(u * kBlock_px, v * kBlock_px)];
            block.strikes = std::min(kStrikes, (block.until > now.ns ? block.strikes : 0) + strikes);
            block.until = last_until_;
        }
    }
}

bool PixelMask::is_drawn(const Eigen::Vector2d& uv) const {
    const Eigen::Vector2i pixel = pixel_of(uv);
    return drawn_[static_cast<std::size_t>(pixel.y()) * static_cast<std::size_t>(width_) +
                  static_cast<std::size_t>(pixel.x())];
}

void PixelMask::write(Timestamp now, std::span<std::uint8_t> flags) const {
    FACET_ASSERT(flags.size() >= drawn_.size());
    if (has_drawing_) {
        std::copy(drawn_.begin(), drawn_.end(), flags.begin());
    } else {
        std::fill_n(flags.begin(), drawn_.size(), std::uint8_t{0});
    }
    if (last_until_ <= now.ns) {
        return;
    }
    for (int v = 0; v < height_; ++v) {
        for (int u = 0; u < width_; u += kBlock_px) {
            if (is_covered(block_of(u, v), now)) {
                std::fill_n(flags.begin() + static_cast<std::ptrdiff_t>(v) * width_ + u,
                            std::min(kBlock_px, width_ - u), std::uint8_t{1});
            }
        }
    }
}

double PixelMask::found_share(Timestamp now) const {
    if (last_until_ <= now.ns) {
        return 0.0;
    }
    std::size_t covered = 0;
    for (std::size_t block = 0; block < blocks_.size(); ++block) {
        covered += is_covered(block, now) ? 1 : 0;
    }
    return static_cast<double>(covered) / static_cast<double>(blocks_.size());
}

}  // namespace facet
