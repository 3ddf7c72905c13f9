// SPDX-License-Identifier: BSD-2-Clause
// What a range finder that looks down delivers.
#pragma once

#include <Eigen/Core>

#include "platform/base/timestamp.h"

namespace facet {

/// One reading: where the beam met the ground, in the body frame B (= IMU frame).
struct RangeSample {
    Timestamp stamp;
    Eigen::Vector3d p_B = Eigen::Vector3d::Zero();  ///< (m)
};

}  // namespace facet
