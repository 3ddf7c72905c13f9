// SPDX-License-Identifier: BSD-2-Clause
// Between the program and the module that has the middleware, which is loaded if a vehicle speaks ROS 2.
#pragma once

#include "drivers/ros2/ros2_node.h"

namespace facet {

/// Beside the program, or in ../lib/facet of its folder.
inline constexpr const char* kRos2ModuleFile = "facet_ros2_cyclone.so";
/// What it exports.
inline constexpr const char* kRos2ModuleMake = "facet_make_ros2_node";
/// The node is the caller's. Heap.
using Ros2ModuleMake = Ros2Node* (*)(const Ros2NodeOptions&);

}  // namespace facet
