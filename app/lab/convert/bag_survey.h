// SPDX-License-Identifier: BSD-2-Clause
// What a bag holds, found by reading it once.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "app/lab/convert/bag.h"
#include "app/lab/convert/ros_messages.h"

namespace facet {

/// A topic that a log, or its calibration, can be made of.
struct TopicSurvey {
    RosKind kind = RosKind::kImage;
    std::string type;
    std::string frame;  ///< of the first message
    std::uint64_t count = 0;
    std::int64_t first_ns = 0;  ///< least and greatest stamp of the messages' headers
    std::int64_t last_ns = 0;
    std::int64_t least_delay_ns = std::numeric_limits<std::int64_t>::max();  ///< when recorded, minus the stamp
    bool has_rates = false;        ///< inertial: some angular rate is not zero
    bool has_forces = false;       ///< inertial: some specific force is not zero
    unsigned greatest_sample = 0;  ///< images of 16 bits: of all
    std::uint32_t width = 0;       ///< of the first image (px)
    std::uint32_t height = 0;
    std::string encoding;

    double rate_hz() const {
        return count < 2 || last_ns <= first_ns
                   ? 0.0
                   : static_cast<double>(count - 1) * 1e9 / static_cast<double>(last_ns - first_ns);
    }
};

/// A lens, out of the message.
struct SurveyedLens {
    std::string frame;
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::string distortion_model;
    std::vector<double> d;
    std::array<double, 9> k{};
    std::array<double, 12> p{};
};
struct SurveyedTransform {
    std::string parent;
    std::string child;
    std::array<double, 7> values{};  ///< as RosTransform
};

struct BagSurvey {
    std::map<std::string, TopicSurvey> topics;   ///< of images, inertial samples and poses, by name
    std::map<std::string, SurveyedLens> lenses;  ///< by topic of CameraInfo, the first message
    std::vector<SurveyedTransform> transforms;   ///< of /tf_static
};

/// @param progress  called with the share that has been read
BagSurvey survey_bag(const std::string& path, const Bag::Warn& warn, const std::function<void(double)>& progress,
                     const std::atomic<bool>& stop);

}  // namespace facet
