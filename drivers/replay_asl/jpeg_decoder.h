// SPDX-License-Identifier: BSD-2-Clause
// Decodes JPEG images.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "drivers/replay_asl/grey_image.h"

namespace facet {

/// Decodes a JPEG image to its luma. Storage is reused. Reentrant. Heap.
/// @return kCorrupt, or as take_size(); `error` says why
Status read_jpeg(std::span<const std::uint8_t> bytes, const WantedSize& wanted, GreyImage& grey, std::string& error);

}  // namespace facet
