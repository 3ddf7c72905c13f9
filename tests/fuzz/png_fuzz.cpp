// SPDX-License-Identifier: BSD-2-Clause
// Images of every format, as they are and, if they are PNG, with the chunks' checksums set right: libpng turns away
// whatever was changed, otherwise.
#include <zlib.h>

#include <vector>

#include "drivers/replay_asl/image_decoder.h"
#include "tests/fuzz/fuzz_input.h"

using namespace facet;

namespace {

constexpr std::size_t kSignature = 8;
constexpr std::size_t kAround = 12;  // length and kind before a chunk's data, checksum behind them

std::uint32_t read_big_endian(const std::uint8_t* at) {
    return (std::uint32_t{at[0]} << 24U) | (std::uint32_t{at[1]} << 16U) | (std::uint32_t{at[2]} << 8U) | at[3];
}

void set_checksums_right(std::vector<std::uint8_t>& png) {
    for (std::size_t at = kSignature; at + kAround <= png.size();) {
        const std::size_t length = read_big_endian(png.data() + at);
        if (length > png.size() - at - kAround) {
            return;
        }
        const auto sum = static_cast<std::uint32_t>(crc32(0, png.data() + at + 4, static_cast<uInt>(length + 4)));
        for (std::size_t i = 0; i < 4; ++i) {
            png[at + 8 + length + i] = static_cast<std::uint8_t>(sum >> (24 - 8 * i));
        }
        at += kAround + length;
    }
}

void decode(std::span<const std::uint8_t> png) {
    static ImageDecoder decoder;
    static GreyImage image;
    // A size is always known when a log is replayed: no larger PNG is ever decoded.
    if (ok(decoder.decode(png, 16, 8, image))) {
        test::require(image.width == 16 && image.height == 8 && image.pixels.size() == 16U * 8U);
    } else {
        test::require(!decoder.error().empty());
    }
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    decode({data, size});
    std::vector<std::uint8_t> right(data, data + size);
    set_checksums_right(right);
    decode(right);
    return 0;
}
