// SPDX-License-Identifier: BSD-2-Clause
// How a sensor's axes lie in the body.
#pragma once

#include <Eigen/Core>
#include <string_view>

#include "platform/base/status.h"

namespace facet {

/// Rotation from sensor axes S to body axes B as a signed permutation: v_B = R_B_S * v_S. Reentrant. No heap.
class AxisMap {
public:
    /// Text such as "x y z" (identity) or "y -x z": which sensor axis each of the body's x, y, z is, with its sign.
    /// @return kInvalidArgument if it is not three different axes, or mirrors (determinant -1).
    Status parse(std::string_view text);

    Eigen::Vector3d apply(const Eigen::Vector3d& v_S) const { return R_B_S_ * v_S; }
    const Eigen::Matrix3d& matrix() const { return R_B_S_; }

private:
    Eigen::Matrix3d R_B_S_ = Eigen::Matrix3d::Identity();
};

}  // namespace facet
