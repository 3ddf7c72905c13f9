// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/replay_asl/png_decoder.h"

#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "tests/support/allocation_guard.h"
#include "tests/support/asl_folder.h"
#include "tests/support/temp_dir.h"

namespace facet::png_decoder_test {
namespace {

constexpr int kWidth = 37;  // odd, so that no row is padded by luck
constexpr int kHeight = 21;

std::vector<std::uint16_t> ramp(int channels, std::uint16_t step) {
    std::vector<std::uint16_t> samples;
    for (int i = 0; i < kWidth * kHeight * channels; ++i) {
        samples.push_back(static_cast<std::uint16_t>(i * step));
    }
    return samples;
}

TEST_CASE("8-bit grey comes back bit for bit") {
    const test::TempDir dir;
    std::vector<std::uint16_t> samples = ramp(1, 7);
    for (std::uint16_t& s : samples) {
        s &= 0xffU;
    }
    const std::string path = dir.write("a.png", test::encode_png(kWidth, kHeight, 1, 8, samples));
    PngDecoder decoder;
    GreyImage image;
    REQUIRE(decoder.decode(path, kWidth, kHeight, image) == Status::kOk);
    CHECK(image.view().width == kWidth);
    CHECK(image.view().height == kHeight);
    CHECK(std::vector<std::uint16_t>(image.pixels.begin(), image.pixels.end()) == samples);
}

TEST_CASE("16-bit grey is rounded to 8 bits") {
    const test::TempDir dir;
    const std::vector<std::uint16_t> samples = ramp(1, 83);
    const std::string path = dir.write("a.png", test::encode_png(kWidth, kHeight, 1, 16, samples));
    PngDecoder decoder;
    GreyImage image;
    REQUIRE(decoder.decode(path, 0, 0, image) == Status::kOk);
    for (std::size_t i = 0; i < samples.size(); ++i) {
        REQUIRE(std::abs(image.pixels[i] - samples[i] / 257.0) <= 0.5 + 1e-3);
    }
}

TEST_CASE("colour becomes luma, alpha is dropped") {
    const test::TempDir dir;
    const int channels = GENERATE(2, 3, 4);
    std::vector<std::uint16_t> samples = ramp(channels, 11);
    for (std::uint16_t& s : samples) {
        s &= 0xffU;
    }
    const std::string path = dir.write("a.png", test::encode_png(kWidth, kHeight, channels, 8, samples));
    PngDecoder decoder;
    GreyImage image;
    REQUIRE(decoder.decode(path, kWidth, kHeight, image) == Status::kOk);
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        const std::uint16_t* s = &samples[i * static_cast<std::size_t>(channels)];
        const double luma = channels == 2 ? s[0] : 0.299 * s[0] + 0.587 * s[1] + 0.114 * s[2];
        REQUIRE(std::abs(image.pixels[i] - luma) <= 1.0);
    }
}

TEST_CASE("images of one kind make no heap call after the first, whatever came between") {
    if (!test::AllocationGuard::active()) {
        return;
    }
    const test::TempDir dir;
    const std::string whole = test::encode_png(kWidth, kHeight, 1, 8, ramp(1, 7));
    const std::string grey = dir.write("grey.png", whole);
    const std::string colour = dir.write("colour.png", test::encode_png(kWidth, kHeight, 3, 16, ramp(3, 11)));
    const std::string cut = dir.write("cut.png", whole.substr(0, whole.size() / 2));
    PngDecoder decoder;
    GreyImage image;
    GreyImage luma;
    REQUIRE(decoder.decode(grey, kWidth, kHeight, image) == Status::kOk);
    REQUIRE(decoder.decode(colour, kWidth, kHeight, luma) == Status::kOk);
    REQUIRE(decoder.decode(cut, kWidth, kHeight, luma) == Status::kCorrupt);
    REQUIRE(decoder.decode(grey, kWidth, kHeight, image) == Status::kOk);
    const std::vector<std::uint8_t> first = image.pixels;
    image.pixels.assign(image.pixels.size(), 0);
    const test::AllocationGuard guard;
    const Status again = decoder.decode(grey, kWidth, kHeight, image);
    const Status other = decoder.decode(colour, kWidth, kHeight, luma);
    const std::uint64_t allocations = guard.allocations();
    CHECK(again == Status::kOk);
    CHECK(other == Status::kOk);
    CHECK(allocations == 0);
    CHECK(image.pixels == first);
}

TEST_CASE("every truncation of a PNG is found, and the decoder goes on working") {
    const test::TempDir dir;
    const std::string bytes = test::encode_png(kWidth, kHeight, 1, 16, ramp(1, 83));
    const std::string path = dir.file("a.png");
    PngDecoder decoder;
    GreyImage image;
    for (std::size_t size = 0; size < bytes.size(); size += 13) {
        dir.write("a.png", bytes.substr(0, size));
        INFO("truncated to " << size << " of " << bytes.size());
        REQUIRE(decoder.decode(path, kWidth, kHeight, image) == Status::kCorrupt);
        REQUIRE_FALSE(decoder.error().empty());
    }
    dir.write("a.png", bytes.substr(0, bytes.size() - 1));
    CHECK(decoder.decode(path, kWidth, kHeight, image) == Status::kCorrupt);
    dir.write("a.png", bytes);
    CHECK(decoder.decode(path, kWidth, kHeight, image) == Status::kOk);
}

TEST_CASE("a flipped byte in the pixels is found by the checksum") {
    const test::TempDir dir;
    std::string bytes = test::encode_png(kWidth, kHeight, 1, 16, ramp(1, 83));
    bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 0x10);
    PngDecoder decoder;
    GreyImage image;
    CHECK(decoder.decode(dir.write("a.png", bytes), 0, 0, image) == Status::kCorrupt);
    CHECK(decoder.decode(dir.write("b.png", "this is not a PNG"), 0, 0, image) == Status::kCorrupt);
}

TEST_CASE("a pipe, a device and a file of gigabytes are refused at once") {
    const test::TempDir dir;
    PngDecoder decoder;
    GreyImage image;
    REQUIRE(mkfifo(dir.file("pipe.png").c_str(), 0600) == 0);
    CHECK(decoder.decode(dir.file("pipe.png"), 0, 0, image) == Status::kNotFound);
    CHECK(decoder.error() == "is not a regular file");
    CHECK(decoder.decode("/dev/zero", 0, 0, image) == Status::kNotFound);
    std::filesystem::resize_file(dir.write("large.png", ""), 3'000'000'000);  // takes no room on the disc
    CHECK(decoder.decode(dir.file("large.png"), 0, 0, image) == Status::kNotFound);
    CHECK(decoder.error() == "has 2861 MiB, more than the 64 that are read");
}

TEST_CASE("missing files, folders and wrong sizes are distinguished") {
    const test::TempDir dir;
    const std::string path = dir.write("a.png", test::encode_png(kWidth, kHeight, 1, 8, ramp(1, 0)));
    PngDecoder decoder;
    GreyImage image;
    CHECK(decoder.decode(dir.file("none.png"), 0, 0, image) == Status::kNotFound);
    CHECK(decoder.decode(dir.path(), 0, 0, image) == Status::kNotFound);
    CHECK(decoder.decode(path, kWidth + 1, kHeight, image) == Status::kInvalidArgument);
    CHECK(decoder.error() == "size is 37x21, not 38x21");
    CHECK(decoder.decode(path, kWidth, kHeight - 1, image) == Status::kInvalidArgument);
}

}  // namespace
}  // namespace facet::png_decoder_test
