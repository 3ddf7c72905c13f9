// SPDX-License-Identifier: BSD-2-Clause
// Readers of the sensor sections of a vehicle file.
#pragma once

#include <string>

#include "app/config/vehicle.h"
#include "app/support/yaml_file.h"

namespace facet {

/// A path that a file names, relative to the folder of that file. Throws InputError if it is no text or empty.
std::string beside(const YamlNode& path);

/// The image size is the calibration's. Throws InputError.
VehicleCameras read_cameras(const YamlNode& node, const Calibration& calibration);
/// Throws InputError.
VehicleTrigger read_trigger(const YamlNode& node);
VehiclePulses read_pulses(const YamlNode& node, double rate_hz);
/// Sets imu_spi, imu_can or imu_mavlink; checks the database and its map. Throws InputError.
void read_imu(const YamlNode& node, Vehicle& vehicle);

}  // namespace facet
