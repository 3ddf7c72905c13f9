// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/pose_difference.h"

#include <cmath>

namespace facet {

PoseDifference pose_difference(const Se3& from, const Se3& to) {
    return {so3_log((from.q.conjugate() * to.q).normalized()), to.p - from.p};
}

double nearest_yaw(const Eigen::Matrix3d& R) { return std::atan2(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1)); }

}  // namespace facet
