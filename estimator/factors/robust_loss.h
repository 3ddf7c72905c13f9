// SPDX-License-Identifier: BSD-2-Clause
// Robust losses on whitened squared residuals.
#pragma once

#include <cmath>

namespace facet {

/// Huber's loss on s = |r|^2 (whitened): rho(s) = s for s <= k^2, else 2 k sqrt(s) - k^2.   [Huber64]
/// Costs are 1/2 rho; the weight rho'(s) scales J^T J and J^T r (no second-order correction). Reentrant. No heap.
struct HuberLoss {
    double threshold = 1.5;  ///< k, in standard deviations

    double cost(double s) const {
        const double k2 = threshold * threshold;
        return s <= k2 ? 0.5 * s : threshold * std::sqrt(s) - 0.5 * k2;
    }
    double weight(double s) const { return s <= threshold * threshold ? 1.0 : threshold / std::sqrt(s); }
};

}  // namespace facet
