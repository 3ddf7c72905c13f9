// SPDX-License-Identifier: BSD-2-Clause
// Reader of the section `imu.iio` of a vehicle file.
#pragma once

#include "app/config/vehicle.h"
#include "app/support/yaml_file.h"

namespace facet {

/// @param rate_hz  that is asked for if the section does not say: the calibration's. Throws InputError.
ImuIioOptions read_imu_iio(const YamlNode& node, double rate_hz);

}  // namespace facet
