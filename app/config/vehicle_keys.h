// SPDX-License-Identifier: BSD-2-Clause
// What the keys of vehicle files mean.
#pragma once

#include <span>

namespace facet {

struct VehicleKey {
    const char* field;    ///< dotted path
    const char* unit;     ///< "" if there is none
    const char* meaning;  ///< a sentence or two
};

/// All of them. Those of one camera, of a second GPIO line and of another thread are those of the first: see
/// config_reference.cpp. Reentrant. No heap.
std::span<const VehicleKey> vehicle_keys();

}  // namespace facet
