// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/planes/plane_config.h"

namespace facet {

Status PlaneConfig::validate() const { return validate_fields(kPlaneFields, *this); }

}  // namespace facet
