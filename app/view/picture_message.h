// SPDX-License-Identifier: BSD-2-Clause
// What the camera sees as a message for Foxglove.
#pragma once

#include <string>

#include "app/view/view_snapshot.h"

namespace facet {

/// foxglove.CompressedImage; empty if the picture cannot be a PNG file. Reentrant. Heap.
std::string picture_image_message(Timestamp stamp, const ViewPicture& picture);

}  // namespace facet
