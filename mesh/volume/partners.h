// SPDX-License-Identifier: BSD-2-Clause
// Which other views a view's depths are compared with.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>

#include "estimator/geometry/se3.h"
#include "platform/base/fixed_vector.h"

namespace facet {

inline constexpr std::size_t kPartners = 3;  ///< to either side in time

/// Three at most, nearer ones first: what they leave unknown is searched in farther ones, whose longer base shows more.
/// In a base of eleven centimetres a step of half a metre in a distance of five is a pixel of disparity, hardly known
/// from a slope; so each is at least twice as far away as the one before.
/// @param T_own_others  the other left cameras in the view's own one, in the order of time from it
/// @param depth_m       that half of what the view shows is nearer than; 0: nothing is known
/// @return their places in `T_own_others`, in that order
FixedVector<std::size_t, kPartners> choose_partners(std::span<const Se3> T_own_others, double depth_m);

}  // namespace facet
