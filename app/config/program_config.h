// SPDX-License-Identifier: BSD-2-Clause
// All parameters of the program: the estimator's, the mesher's and the plane finder's.
#pragma once

#include "estimator/api/config.h"
#include "mesh/mesh_config.h"
#include "mesh/planes/plane_config.h"

namespace facet {

/// What a configuration file sets. The estimator itself knows nothing of the mesh.
struct ProgramConfig : EstimatorConfig {
    MeshConfig mesh;
    PlaneConfig planes;
};

}  // namespace facet
