// SPDX-License-Identifier: BSD-2-Clause
// All parameters of estimator, mesher, plane finder, grid and map.
#pragma once

#include "estimator/api/config.h"
#include "mesh/grid_config.h"
#include "mesh/mesh_config.h"
#include "mesh/planes/plane_config.h"
#include "mesh/volume/map_config.h"

namespace facet {

struct MappingConfig : EstimatorConfig {
    MeshConfig mesh;
    PlaneConfig planes;
    GridConfig grid;
    MapConfig map;
};

}  // namespace facet
