// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/window_config.h"

#include "estimator/values/capacity.h"
#include "platform/base/range_check.h"

namespace facet {

Status WindowConfig::validate() const {
    const bool valid = in_range(keyframes, 3, kMaxKeyframes) && in_range(max_iterations, 1, 50) &&
                       in_range(pixel_sigma_px, 0.1, 5.0) && in_range(loss_threshold, 0.2, 10.0) &&
                       in_range(redundant_px, 0.0, 100.0) && in_range(outlier_threshold_px, 0.5, 20.0);
    return valid ? Status::kOk : Status::kInvalidArgument;
}

}  // namespace facet
