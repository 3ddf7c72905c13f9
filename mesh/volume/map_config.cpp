// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/volume/map_config.h"

namespace facet {

Status MapConfig::validate() const { return validate_fields(kMapFields, *this); }

}  // namespace facet
