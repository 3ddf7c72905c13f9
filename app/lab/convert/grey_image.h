// SPDX-License-Identifier: BSD-2-Clause
// Images of ROS as 8-bit grey.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "app/lab/convert/ros_messages.h"
#include "drivers/replay_asl/grey_image.h"

namespace facet {

/// mono8, mono16, rgb8, bgr8, rgba8, bgra8 (luma 0.299 R + 0.587 G + 0.114 B), bayer_rggb8, bayer_bggr8, bayer_gbrg8,
/// bayer_grbg8 (each colour the mean of its samples in the 3 x 3 pixels around, then luma), OpenCV's 8UC1, 16UC1, 8UC3,
/// 8UC4, and the luma of yuv422, uyvy, yuv422_yuy2, yuyv, nv12, nv21, nv24. Storage is reused. Reentrant. Heap: the
/// image.
/// @param bits  how many of 16 are used: 16 are rounded to 8 as PngDecoder does, fewer scaled to all of 8
/// @return why it cannot be converted; empty if it has been
std::string to_grey(const RosImage& image, unsigned bits, GreyImage& grey);

/// Of an image with samples of 16 bits; 0 of all others, and of one that cannot be read. Reentrant.
unsigned greatest_wide_sample(const RosImage& image);

}  // namespace facet
