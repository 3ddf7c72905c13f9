// SPDX-License-Identifier: BSD-2-Clause
// Images of a ROS 2 topic, whatever their sizes and encodings say.
#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>

#include "drivers/ros2/image_to_grey.h"
#include "tests/fuzz/fuzz_input.h"

using namespace facet;

/// The first 13 bytes are width, height and step, and whether they are big-endian; then comes the encoding up to a
/// zero, then the pixels.
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    constexpr int kWidth = 6;
    constexpr int kHeight = 4;
    constexpr std::size_t kHead = 13;
    if (size < kHead) {
        return 0;
    }
    Ros2Image image;
    std::memcpy(&image.width, data, sizeof image.width);
    std::memcpy(&image.height, data + 4, sizeof image.height);
    std::memcpy(&image.step, data + 8, sizeof image.step);
    image.is_bigendian = (data[12] & 1U) != 0;
    const std::string_view rest(reinterpret_cast<const char*>(data) + kHead, size - kHead);
    image.encoding = rest.substr(0, rest.find('\0'));
    const std::size_t begin = std::min(size, kHead + image.encoding.size() + 1);
    image.data = {data + begin, size - begin};
    static std::array<std::uint8_t, kWidth * kHeight> out;
    ImageFault fault{};
    if (!ok(to_grey(image, kWidth, kHeight, out, fault))) {
        test::require(fault[0] != '\0' && fault.back() == '\0');
    }
    return 0;
}
