// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/replay_asl/tiff_decoder.h"

#include <tiffio.h>

#include <algorithm>
#include <cstring>
#include <memory>

namespace facet {
namespace {

/// A file in memory, as libtiff wants to read one.
struct MemoryFile {
    std::span<const std::uint8_t> bytes;
    std::size_t at = 0;
};

tmsize_t read_some(thandle_t handle, void* out, tmsize_t count) {
    auto* const file = static_cast<MemoryFile*>(handle);
    const std::size_t left = file->bytes.size() - std::min(file->at, file->bytes.size());
    const std::size_t taken = std::min(left, static_cast<std::size_t>(std::max<tmsize_t>(count, 0)));
    std::memcpy(out, file->bytes.data() + (file->bytes.size() - left), taken);
    file->at += taken;
    return static_cast<tmsize_t>(taken);
}
tmsize_t write_nothing(thandle_t /*handle*/, void* /*in*/, tmsize_t /*count*/) { return 0; }
toff_t seek(thandle_t handle, toff_t offset, int whence) {
    auto* const file = static_cast<MemoryFile*>(handle);
    const std::size_t base = whence == SEEK_SET ? 0 : (whence == SEEK_CUR ? file->at : file->bytes.size());
    file->at = base + static_cast<std::size_t>(offset);
    return file->at;
}
int close_nothing(thandle_t /*handle*/) { return 0; }
toff_t size_of(thandle_t handle) { return static_cast<MemoryFile*>(handle)->bytes.size(); }

struct Closer {
    void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};

/// Rows of one sample of 8 or 16 bits. @return false if one cannot be read
bool read_grey_rows(TIFF* tiff, bool is_wide, bool is_inverted, GreyImage& grey) {
    const auto width = static_cast<std::size_t>(grey.width);
    std::vector<std::uint8_t> row(std::max<std::size_t>(static_cast<std::size_t>(TIFFScanlineSize(tiff)), 2 * width));
    for (int v = 0; v < grey.height; ++v) {
        if (TIFFReadScanline(tiff, row.data(), static_cast<std::uint32_t>(v), 0) != 1) {
            return false;
        }
        for (std::size_t u = 0; u < width; ++u) {
            std::uint16_t value = row[u];
            if (is_wide) {
                std::memcpy(&value, row.data() + 2 * u, sizeof(value));
            }
            const std::uint8_t pixel = scaled_to_8_bits(value, is_wide ? 0xFFFFU : 0xFFU);
            grey.pixels[static_cast<std::size_t>(v) * width + u] =
                is_inverted ? static_cast<std::uint8_t>(0xFFU - pixel) : pixel;
        }
    }
    return true;
}

bool read_colours(TIFF* tiff, GreyImage& grey) {
    std::vector<std::uint32_t> pixels(grey.pixels.size());
    if (TIFFReadRGBAImageOriented(tiff, static_cast<std::uint32_t>(grey.width), static_cast<std::uint32_t>(grey.height),
                                  pixels.data(), ORIENTATION_TOPLEFT, 1) != 1) {
        return false;
    }
    std::ranges::transform(pixels, grey.pixels.begin(),
                           [](std::uint32_t p) { return luma(TIFFGetR(p), TIFFGetG(p), TIFFGetB(p)); });
    return true;
}

/// libtiff prints what it finds wrong unless it is told not to, which it can be for the whole program only.
void be_silent() {
    static const bool kOnce = [] {
        TIFFSetErrorHandler(nullptr);
        TIFFSetWarningHandler(nullptr);
        return true;
    }();
    static_cast<void>(kOnce);
}

}  // namespace

Status read_tiff(std::span<const std::uint8_t> bytes, const WantedSize& wanted, GreyImage& grey, std::string& error) {
    error.clear();
    be_silent();
    MemoryFile file{bytes};
    const std::unique_ptr<TIFF, Closer> tiff(
        TIFFClientOpen("image", "rm", &file, read_some, write_nothing, seek, close_nothing, size_of, nullptr, nullptr));
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    if (tiff == nullptr || TIFFGetField(tiff.get(), TIFFTAG_IMAGEWIDTH, &width) != 1 ||
        TIFFGetField(tiff.get(), TIFFTAG_IMAGELENGTH, &height) != 1 || width == 0 || height == 0) {
        error = "damaged TIFF: its header is wrong";
        return Status::kCorrupt;
    }
    FACET_TRY(take_size(width, height, wanted, grey, error));
    std::uint16_t bits = 1;
    std::uint16_t samples = 1;
    std::uint16_t meaning = 0;
    TIFFGetFieldDefaulted(tiff.get(), TIFFTAG_BITSPERSAMPLE, &bits);
    TIFFGetFieldDefaulted(tiff.get(), TIFFTAG_SAMPLESPERPIXEL, &samples);
    TIFFGetField(tiff.get(), TIFFTAG_PHOTOMETRIC, &meaning);
    const bool is_grey = samples == 1 && (bits == 8 || bits == 16) && TIFFIsTiled(tiff.get()) == 0 &&
                         (meaning == PHOTOMETRIC_MINISBLACK || meaning == PHOTOMETRIC_MINISWHITE);
    constexpr std::size_t kMostColoured = std::size_t{64} << 20U;  // pixels: four bytes each while they are read
    if (!is_grey && grey.pixels.size() > kMostColoured) {
        error = "has more than 64 million pixels in colour";
        return Status::kCorrupt;
    }
    const bool is_read = is_grey ? read_grey_rows(tiff.get(), bits == 16, meaning == PHOTOMETRIC_MINISWHITE, grey)
                                 : read_colours(tiff.get(), grey);
    error = is_read ? "" : "damaged TIFF, or of a kind that libtiff does not read";
    return is_read ? Status::kOk : Status::kCorrupt;
}

}  // namespace facet
