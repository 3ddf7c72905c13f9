// SPDX-License-Identifier: BSD-2-Clause
// What calibrating from a flight needs of it: inertial samples, and keyframes with their sightings and states.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/calibration/calibration.h"
#include "estimator/api/config.h"
#include "estimator/values/nav_state.h"
#include "platform/base/samples.h"

namespace facet {

/// A point seen at one keyframe, in distorted pixels as measured: they do not depend on the calibration.
struct PointSighting {
    std::uint32_t point = 0;  ///< the same number at every keyframe that sees it
    Eigen::Vector2d left_px = Eigen::Vector2d::Zero();
    Eigen::Vector2d right_px = Eigen::Vector2d::Zero();  ///< only if has_right
    bool has_right = false;
};

/// A keyframe as the estimator left it.
struct RecordedKeyframe {
    Timestamp image_stamp;  ///< as the log has it, with the calibration's time shift
    Timestamp stamp;        ///< of the state, in the IMU's clock
    NavState state;
    std::vector<PointSighting> sightings;
};

/// A stretch of a flight without restart of the estimator.
struct RecordedFlight {
    std::vector<ImuSample> imu;  ///< of the whole log
    std::vector<RecordedKeyframe> keyframes;
};

struct RecordingOptions {
    std::string dataset;  ///< EuRoC/ASL folder
    EstimatorConfig config;
    Calibration calibration;
    double start_s = 0.0;  ///< from the log's first frame
    double duration_s = 60.0;
    bool show_progress = true;
};

/// Runs the estimator over the log and keeps its keyframes: those of the longest stretch between two restarts.
/// @param stop  set from elsewhere (a signal) to end early, with what there is
/// Throws InputError if dataset, parameters or calibration cannot be used. Heap. Thread-bound.
RecordedFlight record_flight(const RecordingOptions& options, const std::atomic<bool>& stop);

}  // namespace facet
