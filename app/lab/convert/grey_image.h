// SPDX-License-Identifier: BSD-2-Clause
// Images of ROS as 8-bit grey.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "app/lab/convert/ros_messages.h"
#include "drivers/replay_asl/png_decoder.h"

namespace facet {

/// mono8, mono16 (rounded to 8 bits, as PngDecoder does), rgb8, bgr8, rgba8, bgra8 (luma 0.299 R + 0.587 G + 0.114 B),
/// bayer_rggb8, bayer_bggr8, bayer_gbrg8, bayer_grbg8 (each colour the mean of its samples in the 3 x 3 pixels around,
/// then luma), and OpenCV's 8UC1, 16UC1, 8UC3. Storage is reused. Reentrant. Heap: the image.
/// @return why it cannot be converted; empty if it has been
std::string to_grey(const RosImage& image, GreyImage& grey);

/// Decodes a JPEG image to its luma. @return as above
std::string read_jpeg(std::span<const std::uint8_t> bytes, GreyImage& grey);

}  // namespace facet
