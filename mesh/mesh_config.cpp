// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/mesh_config.h"

namespace facet {

Status MeshConfig::validate() const { return validate_fields(kMeshFields, *this); }

}  // namespace facet
