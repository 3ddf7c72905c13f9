// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/frontend_config.h"

#include "estimator/values/capacity.h"

namespace facet {
namespace {

/// False for NaN as well.
template <class T>
bool within(T value, T least, T most) {
    return value >= least && value <= most;
}

}  // namespace

Status FrontendConfig::validate() const {
    const bool detection = within(max_features, 20, kMaxFeatures) && within(surface_points, 0, kMaxSurfacePoints) &&
                           within(min_distance_px, 5.0, 100.0) && within(grid_columns, 1, 40) &&
                           within(grid_rows, 1, 40) && within(corner_quality, 1e-6, 0.5);
    const bool tracking = within(pyramid_levels, 2, 6) && within(window_px, 7, 41) && window_px % 2 == 1 &&
                          within(lk_iterations, 3, 60) && within(lk_epsilon_px, 0.001, 0.5) &&
                          within(forward_backward_px, 0.05, 5.0);
    const bool geometry = within(stereo_epipolar_px, 0.1, 10.0) && within(min_depth_m, 0.05, 5.0) &&
                          within(ransac_threshold_px, 0.2, 10.0) && within(ransac_iterations, 10, 1000);
    const bool policy = within(keyframe_min_interval_s, 0.02, 2.0) && within(keyframe_max_interval_s, 0.1, 5.0) &&
                        keyframe_max_interval_s >= keyframe_min_interval_s && within(keyframe_overlap, 0.1, 1.0) &&
                        within(keyframe_disparity_px, 0.0, 100.0) && within(recall_radius_px, 0.0, 50.0) &&
                        within(still_disparity_px, 0.0, 5.0);
    return detection && tracking && geometry && policy ? Status::kOk : Status::kInvalidArgument;
}

}  // namespace facet
