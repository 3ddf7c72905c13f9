// SPDX-License-Identifier: BSD-2-Clause
// Writes 8-bit grey PNG files, fast rather than small.
#pragma once

#include <string>

#include "platform/base/image_view.h"
#include "platform/base/status.h"

namespace facet {

/// @return kInvalidArgument for an empty view, kIo if the file cannot be written completely. Reentrant. Heap.
Status write_png(const std::string& path, const ImageView& image);

}  // namespace facet
