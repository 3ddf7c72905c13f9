// SPDX-License-Identifier: BSD-2-Clause
// Least squares, where a robust loss is asked for.
#pragma once

#include "estimator/geometry/robust_loss.h"

namespace facet {

/// Weighs all residuals alike: what makes them unequal is known already, or is not to count.
inline constexpr RobustLoss kPlainLoss{1e100, LossKind::kHuber};

}  // namespace facet
