// SPDX-License-Identifier: BSD-2-Clause
// Reads vehicle files.
#pragma once

#include <string>

#include "app/config/vehicle.h"

namespace facet {

/// Reads a vehicle file and the calibration, parameter and database files it names (relative to its folder).
/// app/config/examples has documented examples; what may be left out has the default that vehicle.h or the driver's
/// options state. Throws InputError, one line with file, line and field: for an unknown key, a wrong type, a value out
/// of range, a missing field, or fields that contradict each other.
Vehicle load_vehicle(const std::string& path);

}  // namespace facet
