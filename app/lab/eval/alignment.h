// SPDX-License-Identifier: BSD-2-Clause
// Best transforms of an estimated trajectory onto the true one.
#pragma once

#include <span>

#include "app/lab/eval/trajectory.h"

namespace facet {

enum class AlignmentMode : std::uint8_t {
    kSe3,   ///< rotation and translation, no scale
    kYaw4,  ///< rotation about world z and translation: what gravity leaves free
};

/// Name in reports: "SE(3), no scale" or "4-DoF (yaw + translation), no scale".
const char* to_string(AlignmentMode mode);

/// T_true_est that minimises sum |truth.p - T * estimate.p|^2.
///   SE(3): unit quaternion from the covariance of centred positions, closed form [Horn87]; equals [Umeyama91] without
///          scale.
///   4-DoF: yaw = atan2(sum x_e y_t - y_e x_t, sum x_e x_t + y_e y_t) of centred positions.
/// Identity if there is no pair. With fewer than 3 pairs, or positions on one line, the rotation is one of many.
Se3 align(std::span<const PosePair> pairs, AlignmentMode mode);

/// Scale a similarity transform would choose [Umeyama91] eq. (42): estimate * scale fits best. For information only:
/// stereo-inertial estimates are never scaled. 1 if the estimate does not move.
double similarity_scale(std::span<const PosePair> pairs);

}  // namespace facet
