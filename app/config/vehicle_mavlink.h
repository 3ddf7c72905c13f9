// SPDX-License-Identifier: BSD-2-Clause
// Reader of the section `sinks.mavlink` of a vehicle file.
#pragma once

#include "app/config/vehicle.h"
#include "app/support/yaml_file.h"

namespace facet {

/// Sets mavlink and obstacles; reads the file of the signing key. Throws InputError.
void read_mavlink(const YamlNode& node, Vehicle& vehicle);

}  // namespace facet
