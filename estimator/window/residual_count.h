// SPDX-License-Identifier: BSD-2-Clause
// Collects the residuals of a keyframe.
#pragma once

#include "estimator/values/residuals.h"
#include "estimator/window/window_problem.h"

namespace facet {

/// Adds the residuals of what the oldest keyframe saw, at the current states (WindowProblem::update_cameras() done).
/// No heap. Reentrant.
void count_oldest_residuals(const WindowState& state, const WindowProblem& problem, VisionResiduals& residuals);

}  // namespace facet
