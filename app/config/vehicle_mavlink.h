// SPDX-License-Identifier: BSD-2-Clause
// Readers of the sections `sinks.mavlink` and `imu.mavlink` of a vehicle file.
#pragma once

#include "app/config/vehicle.h"
#include "app/support/yaml_file.h"

namespace facet {

/// Sets mavlink and obstacles; reads the file of the signing key. Throws InputError.
void read_mavlink(const YamlNode& node, Vehicle& vehicle);
/// @param rate_hz  that is asked for if the section does not say: the calibration's. Throws InputError.
ImuMavlinkOptions read_imu_mavlink(const YamlNode& node, double rate_hz);

}  // namespace facet
