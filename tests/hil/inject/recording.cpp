// SPDX-License-Identifier: BSD-2-Clause
#include "tests/hil/inject/recording.h"

#include <algorithm>
#include <stdexcept>

#include "drivers/replay_asl/asl_dataset.h"

namespace facet::hil {
namespace {

std::vector<std::uint8_t> pixels(const ImageView& image) {
    std::vector<std::uint8_t> all;
    for (int y = 0; y < image.height; ++y) {
        const std::uint8_t* const row = image.data + static_cast<std::ptrdiff_t>(y) * image.stride;
        all.insert(all.end(), row, row + image.width);
    }
    return all;
}

}  // namespace

Duration imu_period(const Recording& recording) {
    const auto steps = std::max<std::int64_t>(static_cast<std::int64_t>(recording.imu.size()) - 1, 1);
    return {(recording.imu.back().stamp - recording.imu.front().stamp).ns / steps};
}

Recording load_recording(const std::string& folder, const RecordingPart& part) {
    AslOptions options;
    options.start = Duration::from_seconds(part.start_s);
    if (part.duration_s > 0.0) {
        options.length = Duration::from_seconds(part.duration_s);
    }
    options.decode_images = part.images;
    AslDataset log;
    std::string error;
    if (!ok(log.open(folder, options, {}, error))) {
        throw std::runtime_error(error);
    }
    Recording recording;
    ImuSample sample;
    StereoFrame frame;
    for (;;) {
        const AslDataset::Event event = log.next(sample, frame);
        if (event == AslDataset::Event::kEnd) {
            break;
        }
        if (event == AslDataset::Event::kImu) {
            recording.imu.push_back(sample);
            continue;
        }
        if (part.images) {
            recording.width = frame.left.width;
            recording.height = frame.left.height;
        }
        recording.frames.push_back({frame.stamp, pixels(frame.left), pixels(frame.right)});
    }
    if (recording.imu.empty() || recording.frames.empty()) {
        throw std::runtime_error(folder + ": no samples in that part of the log");
    }
    return recording;
}

}  // namespace facet::hil
