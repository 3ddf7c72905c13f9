// SPDX-License-Identifier: BSD-2-Clause
// Readers of the sections `ros2`, `cameras.ros2`, `imu.ros2` and `sinks.ros2` of a vehicle file.
#pragma once

#include "app/config/vehicle.h"
#include "app/support/yaml_file.h"

namespace facet {

/// All throw InputError, also if the program was built without ROS 2.
Ros2NodeOptions read_ros2(const YamlNode& node);
/// @param calibration  says how many cameras there are, of what size and with what lenses
VehicleRos2Cameras read_ros2_cameras(const YamlNode& node, const Calibration& calibration);
ImuRos2Options read_imu_ros2(const YamlNode& node);
Ros2OutputNames read_ros2_out(const YamlNode& node);

}  // namespace facet
