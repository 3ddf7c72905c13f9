// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/imu/initializer_config.h"

namespace facet {

Status InitializerConfig::validate() const { return validate_fields(kInitializerFields, *this); }

}  // namespace facet
