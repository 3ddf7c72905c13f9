// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/replay_asl/image_decoder.h"

#include <array>
#include <string_view>

#include "drivers/replay_asl/jpeg_decoder.h"
#include "drivers/replay_asl/pgm_decoder.h"
#include "drivers/replay_asl/tiff_decoder.h"
#include "drivers/replay_asl/whole_file.h"

namespace facet {
namespace {

using Read = std::string (*)(std::span<const std::uint8_t>, GreyImage&);

/// How a file of a format begins.
struct Format {
    std::string_view begin;
    Read read;  ///< nullptr: PNG
};
constexpr std::array<Format, 6> kFormats{{{{"\x89PNG", 4}, nullptr},
                                          {{"\xFF\xD8\xFF", 3}, read_jpeg},
                                          {{"P5", 2}, read_pgm},
                                          {{"P6", 2}, read_pgm},
                                          {{"II*\0", 4}, read_tiff},
                                          {{"MM\0*", 4}, read_tiff}}};

}  // namespace

Status ImageDecoder::decode(const std::string& path, int expected_width, int expected_height, GreyImage& image) {
    std::size_t size = 0;
    if (!read_whole_file(path, kMostBytes, file_, size, error_)) {
        return Status::kNotFound;
    }
    return decode(std::span(file_).first(size), expected_width, expected_height, image);
}

Status ImageDecoder::decode(std::span<const std::uint8_t> bytes, int expected_width, int expected_height,
                            GreyImage& image) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const Format* format = nullptr;
    for (const Format& candidate : kFormats) {
        format = format == nullptr && text.starts_with(candidate.begin) ? &candidate : format;
    }
    if (format == nullptr) {
        error_ = bytes.empty() ? "is empty" : "is no PNG, JPEG, PGM or TIFF image";
        return Status::kCorrupt;
    }
    if (format->read == nullptr) {
        const Status status = png_.decode(bytes, expected_width, expected_height, image);
        error_ = (status == Status::kCorrupt ? "damaged PNG: " : "") + png_.error();
        return status;
    }
    error_ = format->read(bytes, image);
    if (!error_.empty()) {
        return Status::kCorrupt;
    }
    if ((expected_width > 0 && image.width != expected_width) ||
        (expected_height > 0 && image.height != expected_height)) {
        error_ = "size is " + std::to_string(image.width) + "x" + std::to_string(image.height) + ", not " +
                 std::to_string(expected_width) + "x" + std::to_string(expected_height);
        image.pixels.clear();
        return Status::kInvalidArgument;
    }
    return Status::kOk;
}

}  // namespace facet
