// SPDX-License-Identifier: BSD-2-Clause
// Decodes PGM and PPM images.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "drivers/replay_asl/grey_image.h"

namespace facet {

/// Binary PGM (P5) and PPM (P6) of 8 or 16 bits: grey, or luma. Storage is reused. Reentrant. Heap.
/// @return kCorrupt, or as take_size(); `error` says why
Status read_pgm(std::span<const std::uint8_t> bytes, const WantedSize& wanted, GreyImage& grey, std::string& error);

}  // namespace facet
