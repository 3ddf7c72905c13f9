// SPDX-License-Identifier: BSD-2-Clause
#include "app/config/config_table.h"

#include <array>

namespace facet {
namespace {

/// Key and accessor of a field, from its name alone.
#define FACET_FIELD(path) #path, ConfigField(+[](EstimatorConfig & config) -> auto& { return config.path; })

// clang-format off
const std::array kTable{
    ConfigEntry{FACET_FIELD(frontend.max_features), "-", 20, 512, "tracks wanted in the left image"},
    ConfigEntry{FACET_FIELD(frontend.min_distance_px), "px", 5, 100, "spacing of new corners to tracks"},
    ConfigEntry{FACET_FIELD(frontend.grid_columns), "-", 1, 40, "detection cells across"},
    ConfigEntry{FACET_FIELD(frontend.grid_rows), "-", 1, 40, "detection cells down"},
    ConfigEntry{FACET_FIELD(frontend.corner_quality), "-", 1e-6, 0.5, "least corner score, share of the image's best"},
    ConfigEntry{FACET_FIELD(frontend.pyramid_levels), "-", 1, 6, "Lucas-Kanade levels, full size included"},
    ConfigEntry{FACET_FIELD(frontend.window_px), "px", 7, 41, "Lucas-Kanade window, odd"},
    ConfigEntry{FACET_FIELD(frontend.lk_iterations), "-", 3, 60, "most Lucas-Kanade steps a level"},
    ConfigEntry{FACET_FIELD(frontend.lk_epsilon_px), "px", 0.001, 0.5, "Lucas-Kanade stops when a step is shorter"},
    ConfigEntry{FACET_FIELD(frontend.forward_backward_px), "px", 0.05, 5, "largest forward-backward distance"},
    ConfigEntry{FACET_FIELD(frontend.stereo_epipolar_px), "px", 0.1, 10, "largest distance of a stereo match to its epipolar line"},
    ConfigEntry{FACET_FIELD(frontend.min_depth_m), "m", 0.05, 5, "nearest stereo depth accepted"},
    ConfigEntry{FACET_FIELD(frontend.ransac_threshold_px), "px", 0.2, 10, "inlier threshold of the 2-point mono test"},
    ConfigEntry{FACET_FIELD(frontend.ransac_iterations), "-", 10, 1000, "hypotheses of the outlier test, fixed"},
    ConfigEntry{FACET_FIELD(frontend.seed), "-", 0, 4294967295.0, "seed of the hypothesis sampler"},
    ConfigEntry{FACET_FIELD(frontend.keyframe_min_interval_s), "s", 0.02, 2, "no keyframe sooner"},
    ConfigEntry{FACET_FIELD(frontend.keyframe_max_interval_s), "s", 0.1, 5, "a keyframe at the latest, also when standing still"},
    ConfigEntry{FACET_FIELD(frontend.keyframe_overlap), "-", 0.1, 1, "keyframe when a smaller share of the last one's tracks is left"},
    ConfigEntry{FACET_FIELD(frontend.keyframe_disparity_px), "px", 0, 100, "keyframe when the rotation-compensated median disparity exceeds this"},
    ConfigEntry{FACET_FIELD(frontend.still_disparity_px), "px", 0, 5, "standing still below this disparity"},
    ConfigEntry{FACET_FIELD(initializer.min_duration_s), "s", 0.02, 2, "inertial data needed before the first frame is taken"},
    ConfigEntry{FACET_FIELD(initializer.max_duration_s), "s", 0.1, 5, "stretch looked at, the newest before the first frame"},
    ConfigEntry{FACET_FIELD(initializer.still_gyro_std_rad_per_s), "rad/s", 1e-4, 1, "standing still below this standard deviation"},
    ConfigEntry{FACET_FIELD(initializer.still_accel_std_m_per_s2), "m/s^2", 1e-3, 5, "standing still below this standard deviation"},
    ConfigEntry{FACET_FIELD(initializer.still_gyro_mean_rad_per_s), "rad/s", 1e-3, 1, "standing still below this mean rate"},
    ConfigEntry{FACET_FIELD(initializer.still_gravity_error_m_per_s2), "m/s^2", 0.01, 3, "standing still if the mean acceleration is this close to g"},
    ConfigEntry{FACET_FIELD(initializer.still_velocity_sigma_m_per_s), "m/s", 1e-4, 1, "velocity prior when still"},
    ConfigEntry{FACET_FIELD(initializer.moving_velocity_sigma_m_per_s), "m/s", 0.1, 50, "velocity prior when moving"},
    ConfigEntry{FACET_FIELD(initializer.still_tilt_sigma_rad), "rad", 1e-4, 0.5, "gravity direction prior when still"},
    ConfigEntry{FACET_FIELD(initializer.moving_tilt_sigma_rad), "rad", 1e-3, 1, "gravity direction prior when moving"},
    ConfigEntry{FACET_FIELD(initializer.gyro_bias_sigma_rad_per_s), "rad/s", 1e-4, 1, "gyro bias prior when it could not be measured"},
    ConfigEntry{FACET_FIELD(initializer.still_gyro_bias_sigma_rad_per_s), "rad/s", 1e-5, 1, "prior of the measured gyro bias"},
    ConfigEntry{FACET_FIELD(initializer.accel_bias_sigma_m_per_s2), "m/s^2", 1e-3, 5, "accelerometer bias prior"},
    ConfigEntry{FACET_FIELD(window.keyframes), "-", 3, 32, "keyframes kept"},
    ConfigEntry{FACET_FIELD(window.max_iterations), "-", 1, 50, "most solver steps a keyframe"},
    ConfigEntry{FACET_FIELD(window.pixel_sigma_px), "px", 0.1, 5, "standard deviation of an observation"},
    ConfigEntry{FACET_FIELD(window.huber_threshold), "-", 0.5, 10, "robust loss on whitened observations"},
    ConfigEntry{FACET_FIELD(window.outlier_threshold_px), "px", 0.5, 20, "observations farther off after optimization are removed"},
    ConfigEntry{FACET_FIELD(calibration.estimate_time_offset), "-", 0, 1, "estimate the time between the cameras' clock and the IMU's"},
    ConfigEntry{FACET_FIELD(calibration.time_offset_sigma_s), "s", 1e-6, 0.1, "prior of the time offset"},
    ConfigEntry{FACET_FIELD(calibration.estimate_extrinsics), "-", 0, 1, "estimate the place of the camera pair on the body"},
    ConfigEntry{FACET_FIELD(calibration.rotation_sigma_rad), "rad", 1e-6, 0.2, "prior of the pair's rotation"},
    ConfigEntry{FACET_FIELD(calibration.translation_sigma_m), "m", 1e-6, 0.2, "prior of the pair's place"},
    ConfigEntry{FACET_FIELD(imu_noise.gyro_noise_rad_per_s_per_sqrt_hz), "rad/s/sqrt(Hz)", 1e-7, 1, "gyro white noise; the calibration's unless given"},
    ConfigEntry{FACET_FIELD(imu_noise.gyro_walk_rad_per_s2_per_sqrt_hz), "rad/s^2/sqrt(Hz)", 1e-9, 1, "gyro bias walk; the calibration's unless given"},
    ConfigEntry{FACET_FIELD(imu_noise.accel_noise_m_per_s2_per_sqrt_hz), "m/s^2/sqrt(Hz)", 1e-6, 10, "accelerometer white noise; the calibration's unless given"},
    ConfigEntry{FACET_FIELD(imu_noise.accel_walk_m_per_s3_per_sqrt_hz), "m/s^3/sqrt(Hz)", 1e-8, 10, "accelerometer bias walk; the calibration's unless given"},
    ConfigEntry{FACET_FIELD(imu_noise.rate_hz), "Hz", 20, 10000, "nominal rate of the IMU; the calibration's unless given"},
};
// clang-format on

#undef FACET_FIELD

}  // namespace

std::span<const ConfigEntry> config_table() { return kTable; }

double config_value(const ConfigEntry& entry, const EstimatorConfig& config) {
    EstimatorConfig copy = config;
    return std::visit([&](auto* field) { return static_cast<double>(field(copy)); }, entry.field);
}

const ConfigEntry* find_out_of_range(const EstimatorConfig& config) {
    for (const ConfigEntry& entry : kTable) {
        const double value = config_value(entry, config);
        if (!(value >= entry.min && value <= entry.max)) {
            return &entry;
        }
    }
    return nullptr;
}

}  // namespace facet
