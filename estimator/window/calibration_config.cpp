// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/calibration_config.h"

#include "platform/base/range_check.h"

namespace facet {

Status CalibrationConfig::validate() const {
    const bool valid = in_range(time_offset_sigma_s, 1e-6, 0.1) && in_range(rotation_sigma_rad, 1e-6, 0.2) &&
                       in_range(translation_sigma_m, 1e-6, 0.2);
    return valid ? Status::kOk : Status::kInvalidArgument;
}

}  // namespace facet
