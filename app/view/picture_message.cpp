// SPDX-License-Identifier: BSD-2-Clause
#include "app/view/picture_message.h"

#include "app/foxglove/schemas.h"
#include "app/support/png_writer.h"

namespace facet {

std::string picture_image_message(Timestamp stamp, const ViewPicture& picture) {
    std::vector<std::uint8_t> file;
    const bool is_made = ok(encode_png({picture.pixels.data(), picture.width, picture.height, picture.width}, file));
    return is_made ? image_message(stamp, kCameraFrame, file, "png") : "";
}

}  // namespace facet
