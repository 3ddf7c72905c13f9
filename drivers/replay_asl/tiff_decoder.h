// SPDX-License-Identifier: BSD-2-Clause
// Decodes TIFF images.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "drivers/replay_asl/grey_image.h"

namespace facet {

/// Decodes the first image of a TIFF file, whatever libtiff reads: grey of 8 and 16 bits as it is, everything else by
/// its colours' luma. Storage is reused. Reentrant. Heap.
/// @return why it cannot be decoded; empty if it has been
std::string read_tiff(std::span<const std::uint8_t> bytes, GreyImage& grey);

}  // namespace facet
