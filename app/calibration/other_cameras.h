// SPDX-License-Identifier: BSD-2-Clause
// Calibrations as Basalt, ORB-SLAM3, VINS-Fusion and OKVIS2 write them.
#pragma once

#include "app/calibration/calibration.h"
#include "app/support/yaml_file.h"

namespace facet {

/// What a file of cameras says of the IMU as well.
struct ImuFigures {
    bool has_noise = false;
    bool has_rate = false;
};

// What such a file says goes into `calibration`. All throw InputError naming file, line and field.

/// T_imu_cam (camera to IMU), intrinsics by camera_type, continuous densities, cam_time_offset_ns, and scale and
/// misalignment of the IMU: a = (1 + S) a_m - bias.
ImuFigures read_basalt(const YamlNode& root, Calibration& calibration);

/// Camera1 and Camera2, or Camera; IMU.T_b_c1 or Tbc (camera to body); Stereo.T_c1_c2 or Tlr (right to left);
/// IMU.Noise*.
ImuFigures read_orb_slam(const YamlNode& root, Calibration& calibration);

/// body_T_cam0 and body_T_cam1, or VINS-Mono's extrinsicRotation and extrinsicTranslation (camera to IMU), and td; the
/// lenses from the files that cam0_calib and cam1_calib name. Its acc_n and gyr_n are weights by hand, not densities,
/// and are not used.
ImuFigures read_vins(const YamlNode& root, Calibration& calibration);

/// cameras: T_SC (camera to IMU) and lens; imu or imu_parameters: sigma_g_c, sigma_a_c, sigma_gw_c, sigma_aw_c, rate.
ImuFigures read_okvis(const YamlNode& root, Calibration& calibration);

}  // namespace facet
