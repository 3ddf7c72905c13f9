// SPDX-License-Identifier: BSD-2-Clause
// All parameters of the program: those of the estimator, the mesher, the grid and the plane finder.
#pragma once

#include "app/calibration/imu_model.h"
#include "mesh/mapping/mapping_config.h"

namespace facet {

/// What a configuration file sets. The estimator itself knows nothing of the mesh.
struct ProgramConfig : MappingConfig {
    ImuModel imu_model;  ///< the calibration's, no parameter of a file: what samples go through before all else
};

}  // namespace facet
