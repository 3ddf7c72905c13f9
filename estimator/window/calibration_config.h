// SPDX-License-Identifier: BSD-2-Clause
// Parameters of the online calibration.
#pragma once

#include "platform/base/parameter_field.h"
#include "platform/base/status.h"

namespace facet {

/// Units, ranges and meanings: kCalibrationFields below.
struct CalibrationConfig {
    /// Time in which any other parameter wanders by the standard deviation of its prior, by warmth and hard landings
    /// (s).
    static constexpr double kWanderTime_s = 3600.0;
    /// How the time offset wanders, a random walk (s/sqrt(s)).
    static constexpr double kTimeOffsetWalk_s_per_sqrt_s = 5e-6;
    bool estimate_time_offset = true;
    double time_offset_sigma_s = 0.005;
    bool estimate_cameras = true;
    double focal_sigma = 5e-4;
    double principal_sigma_px = 0.3;
    double distortion_sigma = 5e-4;
    double late_distortion_sigma = 1e-4;
    double camera_rotation_sigma_rad = 5e-4;
    double camera_position_sigma_m = 3e-4;
    bool estimate_extrinsics = false;
    double rotation_sigma_rad = 0.01;
    double translation_sigma_m = 0.005;
    bool estimate_imu = false;
    double imu_scale_sigma = 0.005;
    double imu_misalignment_sigma_rad = 0.005;

    /// Number of parameters estimated, the first ones of RigCalibration: 0, 1 (time offset), 7 (the camera pair as one
    /// too), 29 (each camera too) or 44 (the IMU's axes too). The prior then holds those that are not estimated.
    int dim() const;
    /// Standard deviation of the prior of a parameter.
    double sigma(int parameter) const;
    /// Standard deviation of the random step of a parameter within a second.
    double walk_per_sqrt_s(int parameter) const;
    /// kInvalidArgument if a field is outside its range.
    Status validate() const;

private:
    double single_camera_sigma(int parameter) const;
};

inline constexpr auto kCalibrationFields = std::to_array<ParameterField<CalibrationConfig>>({
    {FACET_FIELD(CalibrationConfig, estimate_time_offset), "-", 0, 1,
     "Estimate the time offset between the clocks of the cameras and of the IMU."},
    {FACET_FIELD(CalibrationConfig, time_offset_sigma_s), "s", 1e-6, 0.1,
     "Standard deviation of the time offset before the first estimate; the default is what triggering leaves open."},
    {FACET_FIELD(CalibrationConfig, estimate_cameras), "-", 0, 1,
     "Estimate each camera's lens and pose on the body, within 1 sigma of a good calibration."},
    {FACET_FIELD(CalibrationConfig, focal_sigma), "-", 1e-6, 0.1,
     "Relative standard deviation of the given focal lengths."},
    {FACET_FIELD(CalibrationConfig, principal_sigma_px), "px", 1e-3, 50,
     "Standard deviation of the given principal points, each axis."},
    {FACET_FIELD(CalibrationConfig, distortion_sigma), "-", 1e-6, 0.1,
     "Standard deviation of the given coefficients k1 and k2 of the distortion."},
    {FACET_FIELD(CalibrationConfig, late_distortion_sigma), "-", 1e-6, 0.1,
     "Standard deviation of the given coefficients p1 and p2 of the distortion, k3 and k4 if it is equidistant."},
    {FACET_FIELD(CalibrationConfig, camera_rotation_sigma_rad), "rad", 1e-6, 0.1,
     "Standard deviation of each camera's given rotation on the body, each axis; the default is 0.03 degrees."},
    {FACET_FIELD(CalibrationConfig, camera_position_sigma_m), "m", 1e-6, 0.1,
     "Standard deviation of each camera's given position on the body, each axis."},
    {FACET_FIELD(CalibrationConfig, estimate_extrinsics), "-", 0, 1,
     "Estimate how the camera pair as one is mounted on the body when that is known roughly only."},
    {FACET_FIELD(CalibrationConfig, rotation_sigma_rad), "rad", 1e-6, 0.2,
     "Standard deviation of the given rotation of the camera pair on the body."},
    {FACET_FIELD(CalibrationConfig, translation_sigma_m), "m", 1e-6, 0.2,
     "Standard deviation of the given position of the camera pair on the body."},
    {FACET_FIELD(CalibrationConfig, estimate_imu), "-", 0, 1,
     "Estimate scale and misalignment of the IMU's axes: for one that is not calibrated beyond its data sheet."},
    {FACET_FIELD(CalibrationConfig, imu_scale_sigma), "-", 1e-6, 0.1,
     "Relative standard deviation of the scale of each axis of the IMU, from its data sheet."},
    {FACET_FIELD(CalibrationConfig, imu_misalignment_sigma_rad), "rad", 1e-6, 0.1,
     "Standard deviation of the misalignment between axes of the IMU, from its data sheet."},
});

}  // namespace facet
