// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/regularity_config.h"

#include "platform/base/range_check.h"

namespace facet {

Status RegularityConfig::validate() const {
    const bool valid = in_range(sigma_m, 1e-3, 0.5) && in_range(huber_threshold, 0.5, 10.0) &&
                       in_range(min_constraints, 6, 256) && in_range(keep_constraints, 3, 256) &&
                       in_range(min_extent_m, 0.01, 10.0) && in_range(join_sigmas, 0.5, 10.0) &&
                       in_range(leave_sigmas, 0.5, 20.0) && in_range(max_plane_chi2, 1.0, 100.0) &&
                       in_range(pair_sigma_deg, 0.01, 10.0) && in_range(pair_gate_deg, 0.1, 20.0) &&
                       keep_constraints <= min_constraints && join_sigmas <= leave_sigmas;
    return valid ? Status::kOk : Status::kInvalidArgument;
}

}  // namespace facet
