// SPDX-License-Identifier: BSD-2-Clause
// Decodes PNG files into reused 8-bit grey buffers.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "drivers/replay_asl/grey_image.h"
#include "drivers/replay_asl/png_arena.h"
#include "platform/base/status.h"

namespace facet {

/// PNG reader: 1 to 16 bits, grey, palette or colour, with or without alpha (dropped), interlaced or not, becomes 8-bit
/// grey. 16 bits are rounded to 8; colour becomes luma 0.299 R + 0.587 G + 0.114 B of the stored values, without gamma.
/// Thread-bound. Heap: none for an image of the size, kind and number of bytes of one before.
class PngDecoder {
public:
    static constexpr std::size_t kMostBytes = std::size_t{64} << 20U;  ///< of a file: ten times what cameras give

    /// Decodes a file; image's storage is reused.
    /// @param expected_width, expected_height  required size (px); 0 for any up to 16384
    /// @return kNotFound if the file cannot be read, is no regular file or has more than 64 MiB, kCorrupt if it is not
    ///         a complete, intact PNG, kInvalidArgument if its size differs (image then has the size found and no
    ///         pixels). error() has the details.
    Status decode(const std::string& path, int expected_width, int expected_height, GreyImage& image);

    /// Likewise for what is in memory already; never kNotFound.
    Status decode(std::span<const std::uint8_t> png, int expected_width, int expected_height, GreyImage& image);

    const std::string& error() const { return error_; }

private:
    PngArena arena_;
    std::vector<std::uint8_t> file_;  // as long as the longest file so far
    std::vector<std::uint8_t*> rows_;
    std::string error_;
};

}  // namespace facet
