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

/// Of each turn but the last, as many samples as fit between its beginning and the next one's.
void repeat_inertial(Recording& recording) {
    const std::vector<ImuSample> once = recording.imu;
    for (int turn = 1; turn < recording.turns; ++turn) {
        const Duration later{turn * recording.turn.ns};
        const Timestamp begin = once.front().stamp + later;
        while (recording.imu.back().stamp >= begin) {
            recording.imu.pop_back();
        }
        for (ImuSample sample : once) {
            sample.stamp = sample.stamp + later;
            recording.imu.push_back(sample);
        }
    }
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
    const auto frames = static_cast<std::int64_t>(recording.frames.size());
    recording.turns = part.turns;
    recording.turn = {(recording.frames.back().stamp - recording.frames.front().stamp).ns /
                      std::max<std::int64_t>(frames - 1, 1) * frames};
    repeat_inertial(recording);
    return recording;
}

}  // namespace facet::hil
