// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/depth/depth_config.h"

namespace facet {

Status DepthConfig::validate() const { return validate_fields(kDepthFields, *this); }

}  // namespace facet
