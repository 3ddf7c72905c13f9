// SPDX-License-Identifier: BSD-2-Clause
// Calibration of the stereo rig and the IMU, from the files that other programs write.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/calibration/imu_model.h"
#include "estimator/geometry/stereo_rig.h"
#include "estimator/values/imu_noise.h"
#include "platform/base/timestamp.h"

namespace facet {

/// Standard deviations of both cameras, the largest of all axes. Cameras' places and the time offset are not among
/// them: what a flight leaves open of the former moves both cameras alike, the latter changes from start to start.
struct StatedSigmas {
    double focal = 0.0;            ///< relative (-)
    double principal_px = 0.0;     ///< (px)
    double distortion = 0.0;       ///< of the first two coefficients (-)
    double late_distortion = 0.0;  ///< of the other two (-)
    double rotation_rad = 0.0;     ///< (rad)
};

/// Size of a log's images (px); zero: not known.
struct ImageExtent {
    int width = 0;
    int height = 0;
    bool operator==(const ImageExtent&) const = default;
};

/// A file that a calibration was read from.
struct CalibrationFile {
    std::string path;
    std::string place;  ///< where load_calibration finds it below a log's root
};

/// Pictures of what each camera sees of the vehicle itself, of the camera's size: black (0) is not used. Empty: none.
struct MaskFiles {
    std::string left;
    std::string right;
};

/// What calibration files say, with body frame = IMU frame.
struct Calibration {
    StereoRig rig;
    ImuNoise noise;
    ImuModel imu_model;
    Duration camera_time_shift;          ///< t_imu = t_cam + shift (Kalibr's timeshift_cam_imu of cam0)
    std::optional<StatedSigmas> sigmas;  ///< how well the cameras are known, if the files say so
    std::string source;                  ///< files it came from, for the summary
    std::vector<CalibrationFile> files;  ///< none if they are neither all EuRoC's nor all Kalibr's
    MaskFiles masks;
    std::vector<std::string> remarks;  ///< what the files hold and is not used, and what is assumed instead of them
};

/// From a EuRoC/ASL folder: cam0, cam1 and imu0/sensor.yaml. T_BS maps sensor to body; an IMU away from the body frame
/// is composed in: T_I_C = T_B_I^-1 * T_B_C. cam0 may have Kalibr's timeshift_cam_imu. Without a folder cam1 the rig
/// has one camera; likewise a camera chain without cam1. A mask.png beside a camera's file is its mask.
/// @param root  the folder that holds cam0
/// Throws InputError naming file, line and field if a field is missing or implausible.
Calibration load_euroc_calibration(const std::string& root);

/// From Kalibr's camchain.yaml and imu.yaml. T_cam_imu maps IMU to camera; OpenVINS's T_imu_cam the other way; cam1 may
/// have T_cn_cnm1 (cam0 to cam1) instead. Throws as above.
Calibration load_kalibr_calibration(const std::string& camchain_path, const std::string& imu_path);

/// The calibration of a log: its own sensor.yaml files (or Kalibr's camchain.yaml and imu.yaml in the log's root, if
/// there is no cam0/sensor.yaml), unless others are named. What neither says of the IMU's noise is assumed, with a
/// remark.
/// @param root     the log's folder that holds cam0
/// @param cameras  a file of any kind that read_cameras knows, or a folder with the files of EuRoC or Kimera, whose IMU
///                 counts too; empty: the log's own
/// @param imu      Kalibr's imu.yaml, or one of EuRoC, Kimera or OpenVINS; empty: as above
/// @param images   by which a file with several resolutions, or of another one, is read
/// Throws as above.
Calibration load_calibration(const std::string& root, const std::string& cameras, const std::string& imu,
                             const ImageExtent& images = {});

/// Writes the files that a calibration was read from into a log's root, so that load_calibration(root, "", "") gives
/// the same one: byte for byte if they were EuRoC's or Kalibr's, else as sensor.yaml. The folders of its sensors must
/// be there. Throws InputError naming the file.
void keep_calibration(const Calibration& calibration, const std::string& root);

/// Only the cameras of a camchain.yaml; noise stays as it is in `calibration`.
void load_kalibr_cameras(const std::string& camchain_path, Calibration& calibration);
/// Only noise and model of an imu.yaml.
void load_kalibr_imu(const std::string& imu_path, Calibration& calibration);

}  // namespace facet
