// SPDX-License-Identifier: BSD-2-Clause
// Image files of several formats, told by how they begin.
#include "drivers/replay_asl/image_decoder.h"

#include <tiffio.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>

#include "drivers/replay_asl/asl_dataset.h"
#include "tests/support/asl_folder.h"
#include "tests/support/temp_dir.h"

namespace facet::image_decoder_test {
namespace {

constexpr int kWidth = 20;
constexpr int kHeight = 10;

/// @param channels  1 or 3; samples of 8 bits are `grey`, of 16 bits 257 times that
std::string tiff_of(const test::TempDir& dir, std::uint16_t channels, std::uint16_t bits, std::uint16_t compression,
                    std::uint8_t grey) {
    const std::string path = dir.file("made.tif");
    TIFF* const tiff = TIFFOpen(path.c_str(), "w");
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, kWidth);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, kHeight);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, bits);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, channels);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, channels == 1 ? PHOTOMETRIC_MINISBLACK : PHOTOMETRIC_RGB);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, compression);
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 4);
    std::vector<std::uint8_t> row(static_cast<std::size_t>(kWidth) * channels * bits / 8, grey);
    for (std::uint32_t v = 0; v < kHeight; ++v) {
        TIFFWriteScanline(tiff, row.data(), v, 0);
    }
    TIFFClose(tiff);
    return test::read_file(path);
}

std::string pgm_of(const std::string& head, std::size_t bytes, std::uint8_t value) {
    return head + std::string(bytes, static_cast<char>(value));
}

std::string png_of() {
    return test::encode_png(kWidth, kHeight, 1, 8, std::vector<std::uint16_t>(kWidth * kHeight, 140));
}

}  // namespace

TEST_CASE("PNG, JPEG, PGM, PPM and TIFF become grey, whatever the file is called") {
    const test::TempDir dir;
    const std::string images[] = {
        png_of(),
        test::encode_jpeg(kWidth, kHeight, 1, 140),
        pgm_of("P5\n# a camera\n20 10\n255\n", 200, 140),
        pgm_of("P5 20 10 65535\n", 400, 140),
        pgm_of("P5 20 10 65535 ", 400, 140),
        pgm_of("P6\n20 10\n255\n", 600, 140),
        tiff_of(dir, 1, 8, COMPRESSION_NONE, 140),
        tiff_of(dir, 1, 16, COMPRESSION_NONE, 140),
        tiff_of(dir, 1, 8, COMPRESSION_LZW, 140),
        tiff_of(dir, 3, 8, COMPRESSION_NONE, 140),
    };
    ImageDecoder decoder;
    for (const std::string& bytes : images) {
        CAPTURE(bytes.substr(0, 20));
        GreyImage image;
        const std::string path = dir.write("image.png", bytes);
        REQUIRE(decoder.decode(path, kWidth, kHeight, image) == Status::kOk);
        CHECK(image.width == kWidth);
        CHECK(image.height == kHeight);
        REQUIRE(image.pixels.size() == static_cast<std::size_t>(kWidth * kHeight));
        for (const std::uint8_t pixel : image.pixels) {
            CHECK(std::abs(pixel - 140) <= 1);
        }
        CHECK(decoder.decode(path, kWidth + 1, kHeight, image) == Status::kInvalidArgument);
        CHECK(decoder.error() == "size is 20x10, not 21x10");
        CHECK(image.pixels.empty());
        // The header is enough for that: nothing is decoded.
        if (!bytes.starts_with("II")) {  // libtiff's directory is at the end
            dir.write("image.png", bytes.substr(0, bytes.size() - 4));
            CHECK(decoder.decode(path, kWidth, kHeight + 1, image) == Status::kInvalidArgument);
            CHECK(decoder.error() == "size is 20x10, not 20x11");
        }
        // Cut off anywhere it is refused, and nothing else happens.
        for (const std::size_t size : {bytes.size() - 40, bytes.size() / 2, std::size_t{12}, std::size_t{5}}) {
            dir.write("image.png", bytes.substr(0, size));
            CHECK(decoder.decode(path, kWidth, kHeight, image) == Status::kCorrupt);
            CHECK_FALSE(decoder.error().empty());
        }
    }
}

TEST_CASE("what is no image says so, and not that it is a damaged PNG") {
    const test::TempDir dir;
    ImageDecoder decoder;
    GreyImage image;
    CHECK(decoder.decode(dir.file("none"), 0, 0, image) == Status::kNotFound);
    CHECK(decoder.decode(dir.write("a.png", "GIF89a"), 0, 0, image) == Status::kCorrupt);
    CHECK(decoder.error() == "is no PNG, JPEG, PGM or TIFF image");
    CHECK(decoder.decode(dir.write("b.png", ""), 0, 0, image) == Status::kCorrupt);
    CHECK(decoder.error() == "is empty");
    CHECK(decoder.decode(dir.write("c.png", png_of().substr(0, 40)), 0, 0, image) == Status::kCorrupt);
    CHECK(decoder.error().find("damaged PNG: ") == 0);
    for (const char* head : {"P5 0 10 255\n", "P5 20 99999 255\n", "P5 20 10 70000\n", "P5 20", "P5 x 10 255\n"}) {
        CHECK(decoder.decode(dir.write("d.pgm", pgm_of(head, 300, 1)), 0, 0, image) == Status::kCorrupt);
    }
}

TEST_CASE("a log's images are read where they lie, whatever their format") {
    const test::TempDir dir;
    test::write_asl_folder(dir, 4);
    const std::string jpeg = test::encode_jpeg(test::kAslWidth, test::kAslHeight, 1, 90);
    for (const int camera : {0, 1}) {
        const std::string folder = "mav0/cam" + std::to_string(camera);
        std::filesystem::remove_all(dir.file(folder + "/data"));
        std::string rows;
        for (int k = 0; k < 4; ++k) {
            rows += std::to_string(test::kAslBegin + k * test::kAslFrameStep) + ",frame" + std::to_string(k) + ".jpg\n";
            dir.write(folder + "/data/frame" + std::to_string(k) + ".jpg", jpeg);
        }
        dir.write(folder + "/data.csv", rows);
    }
    AslDataset log;
    std::string error;
    std::size_t warnings = 0;
    REQUIRE(ok(log.open(
        dir.path(), {}, [&](const AslWarning&) { ++warnings; }, error)));
    ImuSample sample;
    StereoFrame frame;
    int frames = 0;
    for (auto event = log.next(sample, frame); event != AslDataset::Event::kEnd; event = log.next(sample, frame)) {
        if (event == AslDataset::Event::kFrame) {
            ++frames;
            CHECK(frame.left.at(7, 7) == 90);
            CHECK(frame.right.at(7, 7) == 90);
        }
    }
    CHECK(frames == 4);
    CHECK(warnings == 0);
}

TEST_CASE("inertial samples go on behind the last frame as long as they are requested") {
    const test::TempDir dir;
    test::write_asl_folder(dir, 4);
    const auto samples_behind = [&](double tail_s) {
        AslOptions options;
        options.imu_tail = Duration::from_seconds(tail_s);
        AslDataset log;
        std::string error;
        REQUIRE(ok(log.open(dir.path(), options, nullptr, error)));
        ImuSample sample;
        StereoFrame frame;
        int behind = 0;
        for (auto event = log.next(sample, frame); event != AslDataset::Event::kEnd; event = log.next(sample, frame)) {
            behind += log.is_out_of_frames() && event == AslDataset::Event::kImu ? 1 : 0;
        }
        return behind;
    };
    CHECK(samples_behind(0.0) == 0);
    CHECK(samples_behind(0.02) == 4);
    CHECK(samples_behind(9.0) == 10);  // to the end of the table
}

TEST_CASE("a log may be read as that of one camera") {
    const test::TempDir dir;
    test::write_asl_folder(dir, 4);
    AslOptions options;
    options.left_only = true;
    AslDataset log;
    std::string error;
    REQUIRE(ok(log.open(
        dir.path(), options, [](const AslWarning& w) { FAIL(w.text()); }, error)));
    ImuSample sample;
    StereoFrame frame;
    for (auto event = log.next(sample, frame); event != AslDataset::Event::kEnd; event = log.next(sample, frame)) {
        if (event == AslDataset::Event::kFrame) {
            CHECK_FALSE(frame.left.empty());
            CHECK(frame.right.empty());
        }
    }
}

}  // namespace facet::image_decoder_test
