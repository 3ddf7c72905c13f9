// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/planes/plane_config.h"

namespace facet {

std::string_view PlaneConfig::broken_rule() const {
    if (!(join_m <= stay_m)) {
        return "join_m must not exceed stay_m";
    }
    return join_sigmas <= stay_sigmas ? "" : "join_sigmas must not exceed stay_sigmas";
}

Status PlaneConfig::validate() const { return validate_fields(kPlaneFields, *this); }

}  // namespace facet
