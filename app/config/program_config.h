// SPDX-License-Identifier: BSD-2-Clause
// All parameters of the program: the estimator's and the mesher's.
#pragma once

#include "estimator/api/config.h"
#include "mesh/mesh_config.h"

namespace facet {

/// What a configuration file sets. The estimator itself knows nothing of the mesh.
struct ProgramConfig : EstimatorConfig {
    MeshConfig mesh;
};

}  // namespace facet
