// SPDX-License-Identifier: BSD-2-Clause
// Images of a camera that sends JPEGs, to a decoder that has others before and after.
#include <array>

#include "drivers/common/mjpeg_decoder.h"
#include "tests/fuzz/fuzz_input.h"

using namespace facet;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    constexpr int kWidth = 48;
    constexpr int kHeight = 32;
    static MjpegDecoder decoder(kWidth, kHeight);
    static std::array<std::uint8_t, kWidth * kHeight> out;
    if (!ok(decoder.decode({data, size}, out))) {
        test::require(decoder.problem()[0] != '\0');
    }
    return 0;
}
