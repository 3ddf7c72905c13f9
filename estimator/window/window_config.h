// SPDX-License-Identifier: BSD-2-Clause
// Parameters of the fixed-lag window smoother.
#pragma once

#include "platform/base/status.h"

namespace facet {

/// One line a field: meaning [unit] [range] and why this default.
struct WindowConfig {
    int keyframes = 20;             ///< keyframes kept [3, 32]
    int max_iterations = 6;         ///< most solver steps a keyframe [1, 50]; bounds the time
    double pixel_sigma_px = 0.5;    ///< standard deviation of an observation [0.1, 5]; measured 0.15 rendered, 0.4 real
    bool learn_pixel_sigma = true;  ///< begin with that value and follow the residuals, up to a factor of ten
    double loss_threshold = 1.0;    ///< of Cauchy's loss, in root mean squares of the residuals [0.2, 10]
    double redundant_px = 5.0;  ///< keyframes that moved less from the one before are dropped first [0, 100]; 0: never
    double outlier_threshold_px = 3.0;  ///< observations farther off after optimization are removed [0.5, 20]

    /// kInvalidArgument if a field is outside its range.
    Status validate() const;
};

}  // namespace facet
