// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/api/health_config.h"

namespace facet {

Status HealthConfig::validate() const { return validate_fields(kHealthFields, *this); }

}  // namespace facet
