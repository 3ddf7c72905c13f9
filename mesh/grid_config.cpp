// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/grid_config.h"

namespace facet {

Status GridConfig::validate() const { return validate_fields(kGridFields, *this); }

}  // namespace facet
