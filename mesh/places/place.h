// SPDX-License-Identifier: BSD-2-Clause
// What is remembered of a place: the points seen from there, and how they look.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "mesh/places/descriptor.h"
#include "mesh/places/yaw_pose.h"
#include "platform/base/fixed_vector.h"
#include "platform/base/timestamp.h"
#include "platform/base/typed_id.h"

namespace facet {

/// Points kept of a place, and points of the present view that are looked for in it. Of 128, in the median
/// 45 (office) to 93 (room) are found again.
inline constexpr std::size_t kMaxPlacePoints = 128;
/// Places remembered: 62 MB. A room has some tens, a building of 30 m some hundreds.
inline constexpr std::size_t kMaxPlaces = 2000;

/// A point in G: the frame in the left camera's centre whose axes are those of the odometry's world at that view.
struct PlacePoint {
    Eigen::Vector3f p_G = Eigen::Vector3f::Zero();  ///< (m)
    float depth_sigma = 0.0F;  ///< standard deviation along the line of sight, over the distance, of this point alone
    PointCode code;
    UprightPatch patch{};
};

/// The points of a view.
struct PlaceView {
    Timestamp stamp;
    Eigen::Quaternionf q_G_C = Eigen::Quaternionf::Identity();  ///< the camera's attitude: yaw as in odometry
    float depth_m = 0.0F;                                       ///< median depth of the points
    /// Standard deviation of the error that all inverse depths have in common: that of the stereo calibration (1/m).
    float shared_rho_sigma = 0.0F;
    FixedVector<PlacePoint, kMaxPlacePoints> points;

    Eigen::Vector3f axis_G() const { return q_G_C * Eigen::Vector3f::UnitZ(); }
};

}  // namespace facet
