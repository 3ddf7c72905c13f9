// SPDX-License-Identifier: BSD-2-Clause
// Reads the ground truth of a EuRoC/ASL folder.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/replay_asl/warning.h"
#include "platform/base/status.h"
#include "platform/base/timestamp.h"

namespace facet {

/// True state of the body at one time, in the world of the ground truth (its z need not be up for every recorder).
struct GroundTruthState {
    Timestamp stamp;
    Eigen::Vector3d p_W_B = Eigen::Vector3d::Zero();  ///< (m)
    Eigen::Quaterniond q_W_B = Eigen::Quaterniond::Identity();
    bool has_motion = false;                               ///< the next three are known
    Eigen::Vector3d v_W_B = Eigen::Vector3d::Zero();       ///< (m/s)
    Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();   ///< (rad/s)
    Eigen::Vector3d accel_bias = Eigen::Vector3d::Zero();  ///< (m/s^2)
};

/// Path of the ground-truth table of a dataset: DATASET/[mav0/]state_groundtruth_estimate0/data.csv, or `path` itself
/// if it is a file. Empty if there is none.
std::string find_ground_truth(const std::string& path);

/// Reads a table of 17 columns (t[ns], p, q wxyz, v, bg, ba) or 8 (t[ns], p, q wxyz). Bad rows (malformed, not finite,
/// quaternion norm off 1 by more than 1 %, stamp not increasing) are reported to the sink and skipped.
/// @return kIo with `error` set if the file cannot be read or contains no valid row
Status read_ground_truth(const std::string& csv_path, const AslWarningSink& sink, std::vector<GroundTruthState>& states,
                         std::string& error);

/// The state at a stamp: linear interpolation, slerp for rotation. Empty outside the table and in gaps longer than
/// `max_gap`.
std::optional<GroundTruthState> interpolate(std::span<const GroundTruthState> truth, Timestamp t,
                                            Duration max_gap = Duration::from_seconds(0.5));

}  // namespace facet
