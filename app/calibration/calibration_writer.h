// SPDX-License-Identifier: BSD-2-Clause
// Writes a calibration in the forms that other programs read.
#pragma once

#include <string>
#include <vector>

#include "app/calibration/calibration.h"
#include "app/support/text_file.h"

namespace facet {

/// A lens in Kalibr's words.
struct LensText {
    const char* model;
    std::vector<double> intrinsics;
    const char* distortion;  ///< EuRoC says radial-tangential for radtan
    std::vector<double> coefficients;
};
LensText describe_lens(const CameraIntrinsics& k);

/// "[1, 2, 3]", twelve digits.
std::string list_text(const std::vector<double>& values);

/// Kalibr's accelerometers and gyroscopes, indented by so much; nothing of an ideal IMU.
void write_imu_model(TextFile& file, const ImuModel& model, const std::string& indent);

// All throw InputError if a file cannot be written.

/// FOLDER/cam0, cam1 and imu0/sensor.yaml as EuRoC has them. Folders are made.
void write_sensor_files(const Calibration& calibration, const std::string& folder);

/// Kalibr's camchain-imucam.yaml and imu.yaml, from all of which OpenVINS's differ in T_imu_cam alone.
void write_kalibr_files(const Calibration& calibration, const std::string& folder);

/// FOLDER/stereo.yaml for OpenCV: image_width, image_height, M1, D1, M2, D2, and R, T from left to right. Throws
/// InputError also if a lens is none of OpenCV's, or one camera is all there is.
void write_opencv_file(const Calibration& calibration, const std::string& folder);

}  // namespace facet
