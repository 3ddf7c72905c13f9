// SPDX-License-Identifier: BSD-2-Clause
// Writes 8-bit grey PNG files, fast rather than small.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "platform/base/image_view.h"
#include "platform/base/status.h"

namespace facet {

/// @return kInvalidArgument for an empty view, kIo if the file cannot be written completely. Reentrant. Heap.
Status write_png(const std::string& path, const ImageView& image);

/// The same file in memory. @return kInvalidArgument for an empty view (bytes untouched), kIo if libpng refuses the
/// image. Reentrant. Heap.
Status encode_png(const ImageView& image, std::vector<std::uint8_t>& bytes);

}  // namespace facet
