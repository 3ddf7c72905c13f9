// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/mesh_config.h"

#include "platform/base/range_check.h"

namespace facet {

Status MeshConfig::validate() const {
    const bool landmarks_ok = in_range(max_depth_m, 0.5, 100.0) && in_range(max_depth_sigma_m, 1e-3, 10.0) &&
                              in_range(max_chi2, 0.1, 1000.0) && in_range(recent_keyframes, 0, 32) &&
                              in_range(recent_distance_px, 0.0, 200.0);
    const bool filters_ok = in_range(min_side_ratio, 0.0, 1.0) && in_range(min_elongation, 0.0, 10.0) &&
                            in_range(max_side_m, 0.05, 100.0) && in_range(max_flat_side_m, 0.05, 100.0) &&
                            in_range(max_grazing_deg, 1.0, 90.0) && in_range(step_sigmas, 0.0, 20.0) &&
                            in_range(max_step_slope, 0.1, 100.0) && in_range(gradient_step_slope, 0.1, 100.0) &&
                            in_range(strong_gradient, 1.0, 255.0) && in_range(coplanar_m, 0.0, 1.0) &&
                            in_range(lonely_side_m, 0.05, 100.0) && in_range(lonely_neighbours, 0, 3);
    const bool evidence_ok = in_range(conflict_margin_m, 0.0, 10.0) && in_range(min_contradictions, 1, 1000) &&
                             in_range(hole_planarity_m, 0.0, 1.0);
    return landmarks_ok && filters_ok && evidence_ok ? Status::kOk : Status::kInvalidArgument;
}

}  // namespace facet
