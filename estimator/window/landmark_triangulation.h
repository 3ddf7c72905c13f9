// SPDX-License-Identifier: BSD-2-Clause
// The position of a window's landmark, from its sightings at the present camera poses.
#pragma once

#include <Eigen/Core>
#include <span>

#include "estimator/window/regularity_config.h"
#include "estimator/window/window_cameras.h"

namespace facet {

/// Standard deviation of the prior on inverse depth (1/m) of a first guess: weak against any real baseline, puts a
/// point without one at infinity.
inline constexpr double kRhoPriorSigma = 3.0;

/// Triangulates a landmark, held on its plane if it has one, and sets its point.
/// @param steps  of Gauss-Newton at most, from the landmark's point; without one, or if that fails, a first guess is
///               computed from the sightings alone
/// @param weights  of either camera of each observation, with which steps from the landmark's point are made; empty:
///                 those of the robust loss there
/// @return false if that fails (landmark untouched). Reentrant. No heap.
bool triangulate_landmark(const WindowState& state, const WindowCameras& cameras, const RegularityConfig& regularity,
                          int steps, Landmark& landmark, std::span<const Eigen::Vector2f> weights = {});

}  // namespace facet
