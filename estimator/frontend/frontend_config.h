// SPDX-License-Identifier: BSD-2-Clause
// Parameters of the front-end.
#pragma once

#include <cstdint>

#include "platform/base/status.h"

namespace facet {

/// One line a field: meaning [unit] [range] and why this default.
struct FrontendConfig {
    int max_features = 300;         ///< tracks wanted in the left image [20, 512]; the paper's value
    int surface_points = 200;       ///< further corners that a keyframe matches in stereo, for the mesh alone [0, 384]
    double min_distance_px = 20.0;  ///< spacing of new corners to tracks [5, 100]; the paper's value
    int grid_columns = 12;          ///< detection cells across [1, 40]; even spread
    int grid_rows = 8;              ///< detection cells down [1, 40]
    double corner_quality = 1e-3;   ///< least corner score, share of the image's best [1e-6, 0.5]
    int pyramid_levels = 3;  ///< Lucas-Kanade levels incl. full size [2, 6]; the prediction does the rest, 4 lose more
    int window_px = 15;      ///< diameter of the patch, odd [7, 41]; 21 is 10 % more precise, but costs twice the time
    int lk_iterations = 20;  ///< most steps a level [3, 60]
    double lk_epsilon_px = 0.01;           ///< stop when a step is shorter [0.001, 0.5]
    double forward_backward_px = 0.5;      ///< largest forward-backward distance [0.05, 5]
    double stereo_epipolar_px = 1.5;       ///< largest distance to the epipolar line of a stereo match [0.1, 10]
    double min_depth_m = 0.3;              ///< nearest stereo depth accepted [0.05, 5]
    double ransac_threshold_px = 1.5;      ///< inlier threshold of the 2-point mono test [0.2, 10]
    int ransac_iterations = 100;           ///< fixed number of hypotheses [10, 1000]; deterministic
    std::uint32_t seed = 1;                ///< of the hypothesis sampler
    double keyframe_min_interval_s = 0.2;  ///< no keyframe sooner [0.02, 2]; the paper's value
    double keyframe_max_interval_s = 1.0;  ///< a keyframe at the latest, also when standing still [0.1, 5]
    double keyframe_overlap = 0.7;         ///< keyframe when fewer of the last keyframe's tracks are left [0.1, 1]
    double keyframe_disparity_px =
        8.0;                          ///< keyframe when the rotation-compensated median disparity exceeds this [0, 100]
    double recall_radius_px = 15.0;   ///< lost landmarks are searched this far from their prediction [0, 50]; 0: never
    double still_disparity_px = 0.5;  ///< below: standing still [0, 5]

    /// kInvalidArgument if a field is outside its range.
    Status validate() const;
};

}  // namespace facet
