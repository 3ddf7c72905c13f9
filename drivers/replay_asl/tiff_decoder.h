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
/// @return kCorrupt, or as take_size(); `error` says why
Status read_tiff(std::span<const std::uint8_t> bytes, const WantedSize& wanted, GreyImage& grey, std::string& error);

}  // namespace facet
