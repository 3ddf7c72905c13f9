// SPDX-License-Identifier: BSD-2-Clause
// Reader of the section `imu.serial` of a vehicle file.
#pragma once

#include "app/config/vehicle.h"
#include "app/support/yaml_file.h"

namespace facet {

/// Throws InputError.
ImuSerialOptions read_imu_serial(const YamlNode& node);

}  // namespace facet
