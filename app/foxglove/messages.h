// SPDX-License-Identifier: BSD-2-Clause
// Messages for Foxglove and its like: plain values as JSON after the schemas of schemas.h.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "estimator/api/estimate.h"
#include "estimator/geometry/se3.h"
#include "estimator/values/stage.h"
#include "platform/base/timestamp.h"

namespace facet {

// All functions are reentrant and use the heap. Stamps before the epoch are written as zero: the schema of a stamp has
// no sign. Numbers have all their digits; what is not finite is written as null.

/// foxglove.PoseInFrame of a frame whose pose in `frame` is T.
std::string pose_message(Timestamp stamp, const char* frame, const Se3& T);

/// foxglove.PosesInFrame.
std::string path_message(Timestamp stamp, const char* frame, std::span<const Se3> poses);

/// foxglove.FrameTransform: p_parent = T * p_child.
std::string transform_message(Timestamp stamp, const char* parent, const char* child, const Se3& T);

/// foxglove.CompressedImage.
/// @param file    the whole file of the image
/// @param format  "png" or "jpeg"
std::string image_message(Timestamp stamp, const char* frame, std::span<const std::uint8_t> file, const char* format);

/// facet.Health: the fields of health.csv, the reasons as a number and by name.
/// @param reasons  as joined by '|' for health.csv
std::string health_message(Timestamp stamp, const Health& health, std::string_view reasons);

/// facet.Calibration: what calibration.csv has, the corrections and their standard deviations.
std::string calibration_message(Timestamp stamp, const CalibrationEstimate& estimate);

/// A time by the wall's clock and by the processor's.
struct MessageTime {
    double wall_ms = 0.0;
    double processor_ms = 0.0;
};
inline constexpr std::size_t kMessageTimes = 2 + static_cast<std::size_t>(Stage::kCount);
/// The whole frame's, that until its estimate is given out, then each stage's, in the order of Stage.
using MessageTimes = std::array<MessageTime, kMessageTimes>;

/// facet.Timing: the columns of timing.csv.
std::string timing_message(Timestamp stamp, bool is_keyframe, const MessageTimes& times);

}  // namespace facet
