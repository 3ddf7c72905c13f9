// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/regularity_config.h"

namespace facet {

std::string_view RegularityConfig::broken_rule() const {
    if (keep_constraints > min_constraints) {
        return "keep_constraints must not exceed min_constraints";
    }
    return join_sigmas <= kLeaveSigmas ? "" : "join_sigmas must not exceed leave_sigmas";
}

Status RegularityConfig::validate() const { return validate_fields(kRegularityFields, *this); }

}  // namespace facet
