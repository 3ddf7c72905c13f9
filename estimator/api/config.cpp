// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/api/config.h"

namespace facet {

Status EstimatorConfig::validate() const {
    FACET_TRY(frontend.validate());
    FACET_TRY(initializer.validate());
    FACET_TRY(window.validate());
    FACET_TRY(calibration.validate());
    FACET_TRY(regularity.validate());
    FACET_TRY(range.validate());
    FACET_TRY(health.validate());
    FACET_TRY(imu_limits.validate());
    FACET_TRY(imu_noise.validate());
    return gravity.validate();
}

}  // namespace facet
