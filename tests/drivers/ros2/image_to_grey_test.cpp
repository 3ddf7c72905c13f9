// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/ros2/image_to_grey.h"

#include <catch2/catch.hpp>
#include <limits>
#include <string>
#include <vector>

#include "drivers/ros2/ros2_node.h"
#include "tests/support/allocation_guard.h"

namespace facet::image_to_grey_test {
namespace {

struct Converted {
    Status status;
    std::vector<std::uint8_t> grey;
    std::string fault;
};

Converted convert(const Ros2Image& image, int width, int height) {
    Converted result{Status::kOk, std::vector<std::uint8_t>(static_cast<std::size_t>(width * height), 9), {}};
    ImageFault fault{};
    {
        const test::AllocationGuard guard;
        result.status = to_grey(image, width, height, result.grey, fault);
        const std::uint64_t allocations = guard.allocations();
        CHECK(allocations == 0);
    }
    result.fault = fault.data();
    return result;
}

Ros2Image image_of(const char* encoding, std::uint32_t width, std::uint32_t height, std::uint32_t step,
                   const std::vector<std::uint8_t>& data) {
    Ros2Image image;
    image.encoding = encoding;
    image.width = width;
    image.height = height;
    image.step = step;
    image.data = data;
    return image;
}

TEST_CASE("grey images are copied without the padding of their rows") {
    const std::vector<std::uint8_t> data{1, 2, 99, 3, 4};  // the last row needs no padding
    for (const char* encoding : {"mono8", "8UC1"}) {
        CHECK(convert(image_of(encoding, 2, 2, 3, data), 2, 2).grey == std::vector<std::uint8_t>{1, 2, 3, 4});
    }
}

TEST_CASE("of 16 bits the upper 8 count, whichever comes first") {
    const std::vector<std::uint8_t> data{0x34, 0x12, 0xff, 0x7f};
    Ros2Image image = image_of("mono16", 2, 1, 4, data);
    CHECK(convert(image, 2, 1).grey == std::vector<std::uint8_t>{0x12, 0x7f});
    image.is_bigendian = true;
    CHECK(convert(image, 2, 1).grey == std::vector<std::uint8_t>{0x34, 0xff});
}

TEST_CASE("a mosaic becomes the same grey at every pixel, whichever colour comes first, and ramps do not move") {
    constexpr int kSize = 6;
    const std::array<std::uint8_t, 3> colour{200, 100, 40};  // red, green, blue
    const struct {
        const char* encoding;
        std::array<std::size_t, 4> order;  // of the first two rows
    } mosaics[] = {{"bayer_rggb8", {0, 1, 1, 2}},
                   {"bayer_bggr8", {2, 1, 1, 0}},
                   {"bayer_gbrg8", {1, 2, 0, 1}},
                   {"bayer_grbg8", {1, 0, 2, 1}}};
    for (const auto& mosaic : mosaics) {
        CAPTURE(mosaic.encoding);
        std::vector<std::uint8_t> data(kSize * kSize);
        std::vector<std::uint8_t> ramp(kSize * kSize);
        for (std::size_t i = 0; i < data.size(); ++i) {
            data[i] = colour[mosaic.order[i / kSize % 2 * 2 + i % kSize % 2]];
            ramp[i] = static_cast<std::uint8_t>(20 + 4 * (i % kSize) + 8 * (i / kSize));
        }
        const Converted flat = convert(image_of(mosaic.encoding, kSize, kSize, kSize, data), kSize, kSize);
        CHECK(flat.status == Status::kOk);
        CHECK(flat.grey == std::vector<std::uint8_t>(data.size(), (200 + 2 * 100 + 40) / 4));
        const Converted tilted = convert(image_of(mosaic.encoding, kSize, kSize, kSize, ramp), kSize, kSize);
        for (const std::size_t v : {1U, 2U, 4U}) {
            for (const std::size_t u : {1U, 3U, 4U}) {
                CHECK(tilted.grey[v * kSize + u] == ramp[v * kSize + u]);
            }
        }
    }
    CHECK(convert(image_of("bayer_rggb8", 1, 1, 1, {7}), 1, 1).grey == std::vector<std::uint8_t>{7});
}

TEST_CASE("grey in colours stays as it is, and colours weigh as the eye has them") {
    for (int grey = 0; grey < 256; ++grey) {
        const std::vector<std::uint8_t> data(4, static_cast<std::uint8_t>(grey));
        for (const char* encoding : {"rgb8", "bgr8", "rgba8", "bgra8", "8UC3"}) {
            CHECK(convert(image_of(encoding, 1, 1, 4, data), 1, 1).grey[0] == grey);
        }
    }
    const std::vector<std::uint8_t> red{255, 0, 0};
    CHECK(convert(image_of("rgb8", 1, 1, 3, red), 1, 1).grey[0] == 77);
    CHECK(convert(image_of("bgr8", 1, 1, 3, red), 1, 1).grey[0] == 29);
}

TEST_CASE("of YUV images the luma counts") {
    const std::vector<std::uint8_t> data{128, 10, 129, 20};
    CHECK(convert(image_of("yuv422", 2, 1, 4, data), 2, 1).grey == std::vector<std::uint8_t>{10, 20});
    CHECK(convert(image_of("yuv422_yuy2", 2, 1, 4, data), 2, 1).grey == std::vector<std::uint8_t>{128, 129});
}

TEST_CASE("an image that cannot be used is refused in words, and nothing is written") {
    const std::vector<std::uint8_t> data(64);
    const auto refused = [](const Ros2Image& image) {
        const Converted result = convert(image, 4, 4);
        CHECK(result.status == Status::kCorrupt);
        CHECK(result.grey == std::vector<std::uint8_t>(16, 9));
        return result.fault;
    };
    CHECK(refused(image_of("bayer_rggb16", 4, 4, 4, data)).find("'bayer_rggb16'") != std::string::npos);
    CHECK(refused(image_of("mono8", 4, 3, 4, data)) == "images are 4x3, the calibration is of 4x4");
    CHECK(refused(image_of("mono8", 4, 4, 3, data)).find("64 bytes in rows of 3") != std::string::npos);
    CHECK(refused(image_of("mono8", 4, 4, 21, data)).find("too few") != std::string::npos);
    const std::uint32_t most = std::numeric_limits<std::uint32_t>::max();
    CHECK_FALSE(refused(image_of("mono8", 4, 4, most, data)).empty());
    CHECK_FALSE(refused(image_of("mono8", most, most, most, data)).empty());
    CHECK_FALSE(refused(image_of("", 4, 4, 4, data)).empty());
    const std::string hostile = "\x1b[2J" + std::string(100'000, 'x');
    const std::string fault = refused(image_of(hostile.c_str(), 4, 4, 4, data));
    CHECK(fault.find('\x1b') == std::string::npos);
    CHECK(fault.size() < sizeof(ImageFault));
    ImageFault words{};
    std::vector<std::uint8_t> small(15);
    CHECK(to_grey(image_of("mono8", 4, 4, 4, data), 4, 4, small, words) == Status::kInvalidArgument);
}

TEST_CASE("topics are named by the rules of ROS 2") {
    for (const char* good : {"/a", "/camera/infra1/image_rect_raw", "/_x/y2"}) {
        CHECK(topic_fault(good) == nullptr);
    }
    for (const char* bad : {"", "/", "a/b", "/a//b", "/a/", "/2a", "/a/3", "/a b", "/a-b", "/\xc3\xa4"}) {
        CHECK(topic_fault(bad) != nullptr);
    }
    CHECK(topic_fault("/" + std::string(300, 'a')) != nullptr);
    CHECK(camera_info_topic("/camera/infra1/image_rect_raw") == "/camera/infra1/camera_info");
    CHECK(camera_info_topic("/left/image_raw/compressed") == "/left/camera_info");
    CHECK(camera_info_topic("/image") == "/camera_info");
}

}  // namespace
}  // namespace facet::image_to_grey_test
