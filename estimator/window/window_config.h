// SPDX-License-Identifier: BSD-2-Clause
// Parameters of the fixed-lag window smoother.
#pragma once

#include "platform/base/status.h"

namespace facet {

/// One line a field: meaning [unit] [range] and why this default.
struct WindowConfig {
    int keyframes = 20;                 ///< keyframes kept [3, 32]
    int max_iterations = 6;             ///< most solver steps a keyframe [1, 50]; bounds the time
    double pixel_sigma_px = 1.0;        ///< standard deviation of an observation [0.1, 5]
    double huber_threshold = 1.5;       ///< robust loss on whitened observations [0.5, 10]
    double outlier_threshold_px = 3.0;  ///< observations farther off after optimization are removed [0.5, 20]
    double min_parallax_deg = 0.3;      ///< landmark left out below, unless seen in stereo [0, 10]
    double max_depth_m = 100.0;         ///< landmarks farther are treated as being at that depth [5, 1e4]

    Status validate() const;
};

}  // namespace facet
