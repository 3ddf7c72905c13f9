// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/values/gravity.h"

namespace facet {

Status GravityConfig::validate() const { return validate_fields(kGravityFields, *this); }

}  // namespace facet
