// SPDX-License-Identifier: BSD-2-Clause
// Decodes PGM and PPM images.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "drivers/replay_asl/grey_image.h"

namespace facet {

/// Binary PGM (P5) and PPM (P6) of 8 or 16 bits: grey, or luma. Storage is reused. Reentrant. Heap.
/// @return why it cannot be decoded; empty if it has been
std::string read_pgm(std::span<const std::uint8_t> bytes, GreyImage& grey);

}  // namespace facet
