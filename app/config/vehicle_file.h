// SPDX-License-Identifier: BSD-2-Clause
// Reads vehicle files.
#pragma once

#include <string>
#include <vector>

#include "app/config/vehicle.h"
#include "app/support/yaml_file.h"

namespace facet {

/// Reads a vehicle file and the calibration, parameter and database files it names (relative to its folder).
/// app/config/examples has documented examples; what may be left out has the default that vehicle.h or the driver's
/// options state. Throws InputError, one line with file, line and field: for an unknown key, a wrong type, a value out
/// of range, a missing field, or fields that contradict each other.
Vehicle load_vehicle(const std::string& path);

/// The same, but goes on to the next section after an error. @return the first error of every section, in the file's
/// order as load_vehicle reads it; empty if the vehicle is whole. Throws InputError only if the file is not YAML.
std::vector<std::string> check_vehicle(const std::string& path, Vehicle& vehicle);

/// The same of a file's content.
/// @param known  the calibration, instead of those files that `calibration` names; or nullptr
std::vector<std::string> check_vehicle(const YamlNode& file, const Calibration* known, Vehicle& vehicle);

}  // namespace facet
