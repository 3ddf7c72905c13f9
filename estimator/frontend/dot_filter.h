// SPDX-License-Identifier: BSD-2-Clause
// Takes bright dots out of images: those of an infrared emitter, which moves with the vehicle.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>

#include "platform/base/image_view.h"

namespace facet {

/// Grey-scale opening by a square of 5 x 5: each pixel becomes the largest, over the squares that contain it, of the
/// least value in them (Serra 1982). What is brighter than its surroundings and narrower than 5 px disappears, and of
/// the rest edges stay where they are. Heap: in configure() only. Thread-bound.
class DotFilter {
public:
    static constexpr int kSide_px = 5;

    /// For images of at most this size. Memory that is never used is never touched.
    void configure(int width, int height);

    /// @param image  of at most the configured size (FACET_ASSERT) @return valid until the next call
    ImageView open(const ImageView& image);

    /// Whether the brightest pixel next to uv is one of a dot: opening has taken most of its contrast.
    /// @param image   the one that `opened` comes from
    static bool is_dot(const ImageView& image, const ImageView& opened, const Eigen::Vector2d& uv);
    /// Share of the pixels that opening has made darker by more than noise does.
    static double share(const ImageView& image, const ImageView& opened);

private:
    int width_ = 0;  ///< largest
    int height_ = 0;
    std::unique_ptr<std::uint8_t[]> opened_;
    std::unique_ptr<std::uint8_t[]> rows_;  ///< of the steps between: the newest ones
};

}  // namespace facet
