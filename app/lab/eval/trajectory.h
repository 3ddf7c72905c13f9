// SPDX-License-Identifier: BSD-2-Clause
// Trajectories as evaluation sees them: stamped poses, read from files and put in correspondence.
#pragma once

#include <string>
#include <vector>

#include "estimator/geometry/se3.h"
#include "platform/base/timestamp.h"

namespace facet {

/// Pose of the body in some world.
struct StampedPose {
    Timestamp stamp;
    Se3 T_W_B;
};

/// Stamps strictly increase.
using Trajectory = std::vector<StampedPose>;

/// Reads TUM text: "seconds x y z qx qy qz qw", '#' comments; stamps are read to the nanosecond. Throws InputError with
/// file and line for a row that is not 8 finite numbers, a quaternion off unit length by more than 1 %, or stamps that
/// do not increase; also if the file cannot be read. An empty file gives an empty trajectory.
Trajectory read_tum(const std::string& path);

/// One estimated pose and the true pose at its stamp.
struct PosePair {
    Timestamp stamp;
    Se3 truth;
    Se3 estimate;
};

/// Pairs each estimate with the ground truth interpolated at its stamp: position linearly, rotation by slerp. Estimates
/// outside the ground truth, or within a hole of it longer than `max_gap`, are left out.
std::vector<PosePair> associate(const Trajectory& truth, const Trajectory& estimate, Duration max_gap);

}  // namespace facet
