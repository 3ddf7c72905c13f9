// SPDX-License-Identifier: BSD-2-Clause
// Writes the files of an EuRoC/ASL dataset folder, except the images.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <string>

#include "app/lab/sim/imu_synthesis.h"
#include "estimator/geometry/stereo_rig.h"
#include "estimator/values/imu_noise.h"

namespace facet::sim {

/// What goes into a dataset's sensor.yaml and data.csv files.
struct AslContent {
    const StereoRig* rig = nullptr;  ///< its intrinsics as written; the extrinsics are those below
    std::array<Eigen::Matrix4d, 2> T_B_C;
    ImuNoise imu_noise;
    double camera_rate_hz = 20.0;
    std::span<const Timestamp> image_stamps;
    std::span<const ImuRecord> imu;
};

/// Makes the folders OUT/mav0/{cam0/data, cam1/data, imu0, state_groundtruth_estimate0} and their csv and yaml files.
/// @param failed  on kIo the path that could not be written
Status write_asl(const std::string& out, const AslContent& content, std::string& failed);

/// Writes the sensor.yaml of one camera. @param failed as above
Status write_camera_yaml(const std::string& path, int camera, const AslContent& content, std::string& failed);

/// Path of one image of the dataset.
std::string asl_image_path(const std::string& out, int camera, Timestamp stamp);

}  // namespace facet::sim
