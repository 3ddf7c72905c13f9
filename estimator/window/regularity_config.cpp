// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/regularity_config.h"

namespace facet {

Status RegularityConfig::validate() const { return validate_fields(kRegularityFields, *this); }

}  // namespace facet
