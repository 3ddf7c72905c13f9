// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/replay_asl/decode_ahead.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <vector>

#include "drivers/replay_asl/asl_dataset.h"
#include "tests/support/asl_folder.h"

namespace facet::decode_ahead_test {
namespace {

constexpr int kFrames = 20;

std::string image_file(const test::TempDir& dir, int camera, int frame) {
    return dir.file("mav0/cam" + std::to_string(camera) + "/data/" + test::asl_image_name(frame));
}

AslOptions decoding_ahead(bool is_ahead, int loops = 1) {
    AslOptions options;
    options.decode_ahead = is_ahead;
    options.loops = loops;
    return options;
}

/// All that a reader gives and says, in its order.
std::vector<std::string> story(const std::string& path, const AslOptions& options) {
    std::vector<std::string> told;
    AslDataset log;
    std::string error;
    REQUIRE(log.open(
                path, options, [&](const AslWarning& w) { told.push_back(w.text()); }, error) == Status::kOk);
    ImuSample imu;
    StereoFrame frame;
    for (;;) {
        const AslDataset::Event event = log.next(imu, frame);
        if (event == AslDataset::Event::kEnd) {
            return told;
        }
        if (event == AslDataset::Event::kImu) {
            told.push_back("imu " + std::to_string(imu.stamp.ns));
            continue;
        }
        std::string text = "frame " + std::to_string(frame.stamp.ns);
        for (const ImageView& view : {frame.left, frame.right}) {
            text += " image ";
            for (int v = 0; v < view.height; ++v) {
                text.append(reinterpret_cast<const char*>(view.data + v * view.stride),
                            static_cast<std::size_t>(view.width));
            }
        }
        told.push_back(text);
    }
}

TEST_CASE("images decoded ahead are those decoded on demand, with the same warnings in between") {
    const test::TempDir dir;
    test::write_asl_folder(dir, kFrames);
    std::filesystem::remove(image_file(dir, 0, 3));
    std::filesystem::resize_file(image_file(dir, 1, 5), 200);
    dir.write("mav0/cam0/data/" + test::asl_image_name(7),
              test::encode_png(8, 6, 1, 8, std::vector<std::uint16_t>(48)));
    std::filesystem::remove(image_file(dir, 0, 9));
    std::filesystem::remove(image_file(dir, 1, 9));
    const int loops = GENERATE(1, 3);
    const std::vector<std::string> expected = story(dir.path(), decoding_ahead(false, loops));
    const std::vector<std::string> found = story(dir.path(), decoding_ahead(true, loops));
    CHECK(expected.size() > kFrames);
    CHECK(found == expected);
}

TEST_CASE("a log may be left, or opened again, while images are being decoded") {
    const test::TempDir dir;
    test::write_asl_folder(dir, kFrames);
    AslDataset log;
    std::string error;
    for (int i = 0; i < 2; ++i) {
        REQUIRE(log.open(dir.path(), decoding_ahead(true), {}, error) == Status::kOk);
        ImuSample imu;
        StereoFrame frame;
        while (log.next(imu, frame) != AslDataset::Event::kFrame) {
        }
        CHECK(frame.left.at(3, 4) == test::asl_pixel(0, 0, 3, 4));
        // What has been given stays as it is while the next images are decoded.
        AslDataset moved = std::move(log);
        CHECK(frame.right.at(3, 4) == test::asl_pixel(1, 0, 3, 4));
        log = std::move(moved);
    }
}

TEST_CASE("no more frames are asked for than there is room for") {
    const test::TempDir dir;
    test::write_asl_folder(dir, kFrames);
    DecodeAhead ahead({});
    int asked = 0;
    const auto fill = [&] {
        for (; ahead.has_room(); ++asked) {
            ahead.ask({image_file(dir, 0, asked), ""});
        }
    };
    fill();
    CHECK(asked == DecodeAhead::kFrames);
    for (int k = 0; k < 6; ++k) {
        const DecodeAhead::Frame& frame = ahead.take();
        REQUIRE(ok(frame[0].status));
        CHECK(frame[1].path.empty());
        fill();  // leaves the frame in use alone
        CHECK(asked == static_cast<int>(DecodeAhead::kFrames) + k);
        CHECK(frame[0].grey.view().at(5, 6) == test::asl_pixel(0, k, 5, 6));
    }
}

}  // namespace
}  // namespace facet::decode_ahead_test
