// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/window_config.h"

namespace facet {

Status WindowConfig::validate() const { return validate_fields(kWindowFields, *this); }

}  // namespace facet
