// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/range_config.h"

namespace facet {

Status RangeConfig::validate() const { return validate_fields(kRangeFields, *this); }

}  // namespace facet
