// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/common/mjpeg_decoder.h"

#include <catch2/catch.hpp>
#include <random>

#include "tests/support/allocation_guard.h"
#include "tests/support/jpeg_images.h"

namespace facet::mjpeg_decoder_test {
namespace {

using test::Jpeg;

constexpr int kWidth = 328;  // no multiple of a block of chroma
constexpr int kHeight = 120;

/// Mean absolute difference to the picture that was compressed.
double error_of(const std::vector<std::uint8_t>& out) {
    double sum = 0.0;
    for (int v = 0; v < kHeight; ++v) {
        for (int u = 0; u < kWidth; ++u) {
            sum += std::abs(static_cast<double>(out[static_cast<std::size_t>(v * kWidth + u)]) - test::luma_at(u, v));
        }
    }
    return sum / (kWidth * kHeight);
}

TEST_CASE("what cameras send is decoded, in grey or of the usual samplings of colour, with tables or without") {
    const Jpeg kind = GENERATE(Jpeg{}, Jpeg{.is_grey = true}, Jpeg{.h = 2}, Jpeg{.h = 2, .v = 2},
                               Jpeg{.h = 2, .has_tables = false}, Jpeg{.h = 2, .restart_rows = 1});
    CAPTURE(kind.is_grey, kind.h, kind.v, kind.has_tables, kind.restart_rows);
    MjpegDecoder decoder(kWidth, kHeight);
    std::vector<std::uint8_t> bytes = test::jpeg_of(kWidth, kHeight, kind);
    bytes.resize(bytes.size() + 1000);  // a buffer's rest
    std::vector<std::uint8_t> out(kWidth * kHeight, 0xEE);
    for (int i = 0; i < 3; ++i) {
        std::fill(out.begin(), out.end(), std::uint8_t{0xEE});
        REQUIRE(decoder.decode(bytes, out) == Status::kOk);
        CHECK(error_of(out) < 3.0);
    }
}

TEST_CASE("decoding uses no heap, however the image ends") {
    MjpegDecoder decoder(kWidth, kHeight);
    const std::vector<std::uint8_t> good = test::jpeg_of(kWidth, kHeight, {.h = 2, .v = 2});
    const std::vector<std::uint8_t> cut(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(good.size() / 2));
    std::vector<std::uint8_t> out(kWidth * kHeight);
    const test::AllocationGuard guard;
    const Status first = decoder.decode(good, out);
    const Status second = decoder.decode(cut, out);
    const Status third = decoder.decode(good, out);
    const std::uint64_t allocations = guard.allocations();
    CHECK(allocations == 0);
    CHECK(first == Status::kOk);
    CHECK(second == Status::kCorrupt);
    CHECK(third == Status::kOk);
}

TEST_CASE("an image that is cut off, of another size or of another kind is refused, and the next one is good") {
    MjpegDecoder decoder(kWidth, kHeight);
    const std::vector<std::uint8_t> good = test::jpeg_of(kWidth, kHeight, {.h = 2});
    std::vector<std::uint8_t> out(kWidth * kHeight);
    const auto refused_for = [&](const std::vector<std::uint8_t>& bytes) {
        CHECK(decoder.decode(bytes, out) == Status::kCorrupt);
        const std::string words = decoder.problem();
        CHECK(decoder.decode(good, out) == Status::kOk);
        CHECK(error_of(out) < 3.0);
        return words;
    };
    CHECK_THAT(refused_for({}), Catch::Contains("mpty"));
    CHECK_THAT(refused_for({1, 2, 3, 4}), Catch::Contains("Not a JPEG"));
    CHECK_THAT(refused_for(test::jpeg_of(kWidth, kHeight / 2, {})), Catch::Contains("another size"));
    CHECK_THAT(refused_for(test::jpeg_of(kWidth, kHeight, {.is_progressive = true})), Catch::Contains("baseline"));
    for (std::size_t size = 2; size < good.size() - 2; size += 97) {
        CAPTURE(size);
        CHECK_FALSE(refused_for({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)}).empty());
    }
}

TEST_CASE("whatever the bytes, nothing is overrun and a good image is decoded afterwards") {
    MjpegDecoder decoder(kWidth, kHeight);
    const std::vector<std::uint8_t> good = test::jpeg_of(kWidth, kHeight, {.h = 2, .restart_rows = 1});
    std::vector<std::uint8_t> out(kWidth * kHeight + 16, 0x5A);
    std::mt19937 random(3);
    int refused = 0;
    for (int i = 0; i < 1500; ++i) {
        std::vector<std::uint8_t> bytes = good;
        for (unsigned n = 1 + random() % 8; n > 0; --n) {
            const std::size_t range = i % 2 == 0 ? bytes.size() : 640;  // headers, too
            bytes[random() % std::min(range, bytes.size())] = static_cast<std::uint8_t>(random());
        }
        refused += ok(decoder.decode(bytes, {out.data(), kWidth * kHeight})) ? 0 : 1;
        REQUIRE(out[kWidth * kHeight] == 0x5A);
    }
    CHECK(refused > 500);
    REQUIRE(decoder.decode(good, out) == Status::kOk);
    CHECK(error_of(out) < 3.0);
}

}  // namespace
}  // namespace facet::mjpeg_decoder_test
