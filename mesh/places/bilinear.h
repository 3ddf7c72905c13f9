// SPDX-License-Identifier: BSD-2-Clause
// Grey values between pixels.
#pragma once

#include <Eigen/Core>

#include "platform/base/image_view.h"

namespace facet {

/// Contract: 0 <= x < width - 1, 0 <= y < height - 1. Reentrant.
inline float bilinear(const ImageView& image, const Eigen::Vector2f& p) {
    const int u = static_cast<int>(p.x());
    const int v = static_cast<int>(p.y());
    const float a = p.x() - static_cast<float>(u);
    const float b = p.y() - static_cast<float>(v);
    const std::uint8_t* const upper = image.row(v) + u;
    const std::uint8_t* const lower = upper + image.stride;
    return (1.0F - b) * ((1.0F - a) * static_cast<float>(upper[0]) + a * static_cast<float>(upper[1])) +
           b * ((1.0F - a) * static_cast<float>(lower[0]) + a * static_cast<float>(lower[1]));
}

}  // namespace facet
