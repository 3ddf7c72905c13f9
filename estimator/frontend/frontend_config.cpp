// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/frontend_config.h"

#include "estimator/frontend/feature_engine.h"

namespace facet {

std::string_view FrontendConfig::broken_rule() const {
    if (window_px % 2 == 0) {
        return "window_px must be odd";
    }
    if (!(kKeyframeMinInterval_s <= keyframe_max_interval_s)) {
        return "keyframe_min_interval_s must not exceed keyframe_max_interval_s";
    }
    if (uses_opencv() && !has_opencv_engine()) {
        return "backend: this build has no 'opencv', which needs OpenCV's features2d and video when it is built";
    }
    return {};
}

Status FrontendConfig::validate() const { return validate_fields(kFrontendFields, *this); }

}  // namespace facet
