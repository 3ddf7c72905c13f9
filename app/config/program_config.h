// SPDX-License-Identifier: BSD-2-Clause
// All parameters of the program: the estimator's, the mesher's and the plane finder's.
#pragma once

#include "estimator/api/config.h"
#include "mesh/mesh_config.h"
#include "mesh/planes/plane_config.h"
#include "platform/base/timestamp.h"

namespace facet {

/// The estimator may find that images are later than their stamps say, and can then use them only that much later.
/// Frames are therefore given to it when inertial samples reach this far beyond their stamps.
inline constexpr Duration kFrameDelay = Duration::from_seconds(0.02);

/// What a configuration file sets. The estimator itself knows nothing of the mesh.
struct ProgramConfig : EstimatorConfig {
    MeshConfig mesh;
    PlaneConfig planes;
};

}  // namespace facet
