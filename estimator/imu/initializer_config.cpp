// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/imu/initializer_config.h"

namespace facet {

std::string_view InitializerConfig::broken_rule() const {
    return min_duration_s <= max_duration_s ? "" : "min_duration_s must not exceed max_duration_s";
}

Status InitializerConfig::validate() const { return validate_fields(kInitializerFields, *this); }

}  // namespace facet
