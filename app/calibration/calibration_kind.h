// SPDX-License-Identifier: BSD-2-Clause
// Which program wrote a calibration file.
#pragma once

#include <cstdint>
#include <string>

#include "app/support/yaml_file.h"

namespace facet {

enum class CalibrationKind : std::uint8_t {
    kCameraChain,  ///< Kalibr's, and OpenVINS's
    kImu,          ///< Kalibr's imu.yaml, and EuRoC's, OpenVINS's and Kimera's
    kEurocCamera,  ///< sensor.yaml of one camera, and Kimera's
    kBasalt,
    kOrbSlam,
    kVins,       ///< the configuration of VINS-Mono or VINS-Fusion
    kCamodocal,  ///< one camera's lens
    kOkvis,
    kCameraInfo,       ///< ROS's, one camera's lens
    kOpenCvStereo,     ///< matrices of two cameras
    kDepthAi,          ///< of an OAK camera
    kRealSenseImu,     ///< of rs-imu-calibration
    kRealSensePreset,  ///< settings of realsense-viewer
    kUnknown,
};

CalibrationKind kind_of_calibration(const YamlNode& root);

/// Throws InputError that says what kind of file it is and what it lacks as a calibration of cameras against an IMU.
[[noreturn]] void refuse_as_cameras(const YamlNode& root, CalibrationKind kind);
/// Likewise as that of an IMU.
[[noreturn]] void refuse_as_imu(const YamlNode& root, CalibrationKind kind);

}  // namespace facet
