// SPDX-License-Identifier: BSD-2-Clause
// All parameters of the estimator: one struct a module.
#pragma once

#include "estimator/api/health_config.h"
#include "estimator/frontend/frontend_config.h"
#include "estimator/geometry/stereo_rig.h"
#include "estimator/imu/imu_limits.h"
#include "estimator/imu/initializer_config.h"
#include "estimator/values/gravity.h"
#include "estimator/values/imu_noise.h"
#include "estimator/window/calibration_config.h"
#include "estimator/window/range_config.h"
#include "estimator/window/regularity_config.h"
#include "estimator/window/window_config.h"

namespace facet {

struct EstimatorConfig {
    FrontendConfig frontend;
    InitializerConfig initializer;
    WindowConfig window;
    CalibrationConfig calibration;
    RegularityConfig regularity;
    RangeConfig range;
    HealthConfig health;
    ImuLimits imu_limits;
    ImuNoise imu_noise;
    GravityConfig gravity;

    /// kInvalidArgument if a part is invalid.
    Status validate() const;
};

}  // namespace facet
