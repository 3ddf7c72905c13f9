// SPDX-License-Identifier: BSD-2-Clause
// The rights that a vehicle's service needs, as systemd takes them.
#pragma once

#include <string>

#include "app/config/vehicle.h"

namespace facet {

/// A drop-in for facet.service (a file in facet.service.d) that allows what the vehicle file names and nothing else:
/// devices, addresses, a log folder outside of /var/lib/facet, and the files of a PWM channel, which it hands to the
/// service's user before the start, because sysfs has no groups. Cameras and pluggable serial lines are allowed by
/// class, since one that is plugged in again may get another number; all else by name. Reentrant; heap.
std::string service_drop_in(const Vehicle& vehicle);

}  // namespace facet
