// SPDX-License-Identifier: BSD-2-Clause
// All parameters of estimator, mesher, plane finder, depth, grid and map.
#pragma once

#include "estimator/api/config.h"
#include "mesh/depth/depth_config.h"
#include "mesh/grid_config.h"
#include "mesh/mesh_config.h"
#include "mesh/planes/plane_config.h"
#include "mesh/volume/map_config.h"

namespace facet {

struct MappingConfig : EstimatorConfig {
    MeshConfig mesh;
    PlaneConfig planes;
    GridConfig grid;
    DepthConfig depth;
    MapConfig map;
};

}  // namespace facet
