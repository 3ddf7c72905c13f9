// SPDX-License-Identifier: BSD-2-Clause
// The pixels of a ROS 2 image to 8-bit grey.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "drivers/ros2/ros2_messages.h"
#include "platform/base/status.h"

namespace facet {

/// What is wrong with an image, in words, zero-terminated. What comes from the network is cut, and shown without
/// characters that a terminal would obey.
using ImageFault = std::array<char, 160>;

/// mono8, 8UC1 and the luma of yuv422 (UYVY) and yuv422_yuy2 are copied; of mono16 the upper 8 bits count; of rgb8,
/// bgr8, 8UC3 (as bgr8), rgba8 and bgra8 it is (77 R + 150 G + 29 B + 128) / 256, which leaves grey as it is. A mosaic
/// (bayer_rggb8, bayer_bggr8, bayer_gbrg8, bayer_grbg8) is smoothed by [1 2 1] / 4 both ways, mirrored at its borders:
/// (R + 2 G + B) / 4 at every pixel, whichever colour it has, and nothing moves.
/// @param width, height  that the image must have
/// @param out    width * height bytes, rows without padding
/// @param fault  is set if something is wrong
/// @return kCorrupt if the image has another size or encoding, or too few bytes; kInvalidArgument if `out` is too
///         small: `out` untouched. Reentrant. No heap.
Status to_grey(const Ros2Image& image, int width, int height, std::span<std::uint8_t> out, ImageFault& fault);

}  // namespace facet
