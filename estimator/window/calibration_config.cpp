// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/calibration_config.h"

namespace facet {

Status CalibrationConfig::validate() const { return validate_fields(kCalibrationFields, *this); }

}  // namespace facet
