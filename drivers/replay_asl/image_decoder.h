// SPDX-License-Identifier: BSD-2-Clause
// Decodes the image files of a log, whatever their format.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "drivers/replay_asl/grey_image.h"
#include "drivers/replay_asl/png_decoder.h"
#include "platform/base/status.h"

namespace facet {

/// PNG, JPEG, PGM, PPM and TIFF become 8-bit grey; the format is recognised by the first bytes, not by the name.
/// Thread-bound. Heap: none for a PNG image like one before; the others' libraries use it.
class ImageDecoder {
public:
    static constexpr std::size_t kMostBytes = PngDecoder::kMostBytes;

    /// Whether a file that begins so, with four bytes or more, is of one of these formats.
    static bool recognises(std::span<const std::uint8_t> begin);

    /// Decodes a file; image's storage is reused.
    /// @param expected_width, expected_height  required size (px); 0 for any up to 16384
    /// @return kNotFound if the file cannot be read, is no regular file or has more than 64 MiB, kCorrupt if it is not
    ///         a complete, intact image, kInvalidArgument if its size differs, by its header: nothing is decoded then
    ///         (image has the size found and no pixels). error() has the details.
    Status decode(const std::string& path, int expected_width, int expected_height, GreyImage& image);

    /// Likewise for what is in memory already; never kNotFound.
    Status decode(std::span<const std::uint8_t> bytes, int expected_width, int expected_height, GreyImage& image);

    const std::string& error() const { return error_; }

private:
    PngDecoder png_;
    std::vector<std::uint8_t> file_;  // as long as the longest file so far
    std::string error_;
};

}  // namespace facet
