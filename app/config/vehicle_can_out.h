// SPDX-License-Identifier: BSD-2-Clause
// Reader of the section `sinks.can` of a vehicle file.
#pragma once

#include "app/config/vehicle.h"
#include "app/support/yaml_file.h"

namespace facet {

/// Throws InputError.
CanOutOptions read_can_out(const YamlNode& node);

/// Throws InputError if the IMU's node on the same bus has the number that we want for ours.
void check_can_nodes(const YamlNode& node, const Vehicle& vehicle);

}  // namespace facet
