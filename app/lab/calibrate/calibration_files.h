// SPDX-License-Identifier: BSD-2-Clause
// Writes a refined calibration: EuRoC's and Kalibr's files, and the account of every parameter.
#pragma once

#include <string>
#include <vector>

#include "app/calibration/imu_model.h"
#include "app/lab/calibrate/batch.h"
#include "app/lab/calibrate/rig_parameters.h"

namespace facet {

/// A calibration to be written, with the standard deviations of its parameters.
struct RefinedCalibration {
    RigAndTime refined;
    ImuNoise noise;      ///< as given
    ImuModel imu_model;  ///< as given
    RigVector sigma = RigVector::Zero();
};

/// Writes FOLDER/cam0, cam1 and imu0/sensor.yaml in EuRoC/ASL layout, which `--calibration FOLDER` reads, and Kalibr's
/// camchain-imucam.yaml and imu.yaml. Standard deviations stand beside the values as keys of their own, which readers
/// pass over: intrinsics_sigma, distortion_sigma, rotation_sigma_deg, position_sigma_m, timeshift_sigma. The body is
/// the IMU. Throws InputError if a file cannot be written. Heap.
void write_calibration(const RefinedCalibration& calibration, const std::string& folder);

/// What calibration.json says beside the parameters.
struct CalibrationAccount {
    std::string dataset;
    std::string source;  ///< of the calibration as given
    double duration_s = 0.0;
    std::vector<RigParameter> parameters;
};

/// Writes FOLDER/calibration.json: the parameters as given and refined, with sigma, verdict and advice, and how well
/// the images fit before and after. Throws as above.
void write_calibration_json(const CalibrationAccount& account, const BatchResult& result, const std::string& folder);

}  // namespace facet
