// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/replay_asl/image_decoder.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "drivers/replay_asl/jpeg_decoder.h"
#include "drivers/replay_asl/pgm_decoder.h"
#include "drivers/replay_asl/tiff_decoder.h"
#include "drivers/replay_asl/whole_file.h"

namespace facet {
namespace {

using Read = Status (*)(std::span<const std::uint8_t>, const WantedSize&, GreyImage&, std::string&);

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

/// nullptr: of none.
const Format* find_format(std::span<const std::uint8_t> bytes) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const auto* const format =
        std::ranges::find_if(kFormats, [&](const Format& candidate) { return text.starts_with(candidate.begin); });
    return format == kFormats.end() ? nullptr : format;
}

}  // namespace

bool ImageDecoder::recognises(std::span<const std::uint8_t> begin) { return find_format(begin) != nullptr; }

Status ImageDecoder::decode(const std::string& path, int expected_width, int expected_height, GreyImage& image) {
    std::size_t size = 0;
    if (!read_whole_file(path, kMostBytes, file_, size, error_)) {
        return Status::kNotFound;
    }
    return decode(std::span(file_).first(size), expected_width, expected_height, image);
}

Status ImageDecoder::decode(std::span<const std::uint8_t> bytes, int expected_width, int expected_height,
                            GreyImage& image) {
    const Format* const format = find_format(bytes);
    if (format == nullptr) {
        error_ = bytes.empty() ? "is empty" : "is no PNG, JPEG, PGM or TIFF image";
        return Status::kCorrupt;
    }
    if (format->read == nullptr) {
        const Status status = png_.decode(bytes, expected_width, expected_height, image);
        error_ = (status == Status::kCorrupt ? "damaged PNG: " : "") + png_.error();
        return status;
    }
    return format->read(bytes, {expected_width, expected_height}, image, error_);
}

}  // namespace facet
