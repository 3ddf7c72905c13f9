// SPDX-License-Identifier: BSD-2-Clause
// Decodes JPEG images.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "drivers/replay_asl/grey_image.h"

namespace facet {

/// Decodes a JPEG image to its luma. Storage is reused. Reentrant. Heap.
/// @return why it cannot be; empty if it has been
std::string read_jpeg(std::span<const std::uint8_t> bytes, GreyImage& grey);

}  // namespace facet
