// SPDX-License-Identifier: BSD-2-Clause
// ROS bags of both kinds, and the messages in them.
#include "app/lab/convert/bag.h"
#include "app/lab/convert/grey_image.h"
#include "app/support/input_error.h"
#include "drivers/replay_asl/image_decoder.h"
#include "tests/fuzz/fuzz_input.h"

using namespace facet;

namespace {

void read_image(const BagMessage& message) {
    RosImage image;
    if (!read_message(message, image)) {
        return;
    }
    constexpr unsigned kBits = 12;
    GreyImage grey;
    ImageDecoder decoder;
    const bool is_plain = kind_of(message.topic->type) == RosKind::kImage;
    static_cast<void>(greatest_wide_sample(image));
    if (is_plain ? to_grey(image, kBits, grey).empty() : ok(decoder.decode(image.data, 0, 0, grey))) {
        test::require(grey.width > 0 && grey.height > 0);
        test::require(grey.pixels.size() ==
                      static_cast<std::size_t>(grey.width) * static_cast<std::size_t>(grey.height));
    }
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const test::MemoryFile file({data, size});
    try {
        const auto bag =
            open_bag(file.path(), [](const std::string& line) { test::require(line.find('\n') == std::string::npos); });
        for (BagMessage message; bag->next(message);) {
            test::require(message.topic != nullptr);
            RosImu imu;
            RosPose pose;
            switch (kind_of(message.topic->type).value_or(RosKind::kImu)) {
                case RosKind::kImu: static_cast<void>(read_message(message, imu)); break;
                case RosKind::kPose: static_cast<void>(read_message(message, pose)); break;
                default: read_image(message); break;
            }
        }
    } catch (const InputError& e) {
        test::require(std::string_view(e.what()).find('\n') == std::string_view::npos);
    }
    return 0;
}
