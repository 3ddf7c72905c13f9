// SPDX-License-Identifier: BSD-2-Clause
#include "tests/hil/inject/pixel_packing.h"

#include <catch2/catch.hpp>
#include <numeric>

namespace facet::hil::pixel_packing_test {
namespace {

TEST_CASE("Every format that is sent is the grey image again once the driver has unpacked it") {
    constexpr int kWidth = 64;
    constexpr int kHeight = 8;
    std::vector<std::uint8_t> grey(static_cast<std::size_t>(kWidth) * kHeight);
    std::iota(grey.begin(), grey.end(), std::uint8_t{0});  // every value twice
    for (const PixelLayout& layout :
         {PixelLayout{PixelFormat::kGrey}, PixelLayout{PixelFormat::kY10}, PixelLayout{PixelFormat::kY10, 0, true},
          PixelLayout{PixelFormat::kY10p}, PixelLayout{PixelFormat::kY12}, PixelLayout{PixelFormat::kY12, 0, true},
          PixelLayout{PixelFormat::kY012}, PixelLayout{PixelFormat::kY16}, PixelLayout{PixelFormat::kY16, 12, false},
          PixelLayout{PixelFormat::kY16, 12, true}, PixelLayout{PixelFormat::kYuyv}}) {
        CAPTURE(static_cast<int>(layout.format), layout.significant_bits, layout.msb_aligned);
        const std::vector<std::uint8_t> packed = pack(layout, grey);
        const RawImage image{packed,
                             layout.format,
                             kWidth,
                             kHeight,
                             row_bytes(layout.format, kWidth),
                             layout.significant_bits,
                             layout.msb_aligned};
        std::vector<std::uint8_t> back(grey.size());
        REQUIRE(ok(unpack(image, back)));
        REQUIRE(back == grey);
    }
}

}  // namespace
}  // namespace facet::hil::pixel_packing_test
