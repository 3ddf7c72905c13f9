// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/frontend_config.h"

namespace facet {

std::string_view FrontendConfig::broken_rule() const {
    if (window_px % 2 == 0) {
        return "window_px must be odd";
    }
    if (!(keyframe_min_interval_s <= keyframe_max_interval_s)) {
        return "keyframe_min_interval_s must not exceed keyframe_max_interval_s";
    }
    return {};
}

Status FrontendConfig::validate() const { return validate_fields(kFrontendFields, *this); }

}  // namespace facet
