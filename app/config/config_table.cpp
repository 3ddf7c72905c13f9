// SPDX-License-Identifier: BSD-2-Clause
#include "app/config/config_table.h"

#include <array>

namespace facet {
namespace {

/// Key and accessor of a field, from its name alone.
#define FACET_FIELD(path) #path, ConfigField(+[](ProgramConfig & config) -> auto& { return config.path; })

// clang-format off
const std::array kTable{
    ConfigEntry{FACET_FIELD(frontend.max_features), "-", 20, 512, "tracks wanted in the left image"},
    ConfigEntry{FACET_FIELD(frontend.surface_points), "-", 0, 384, "further corners that a keyframe matches in stereo, for the mesh alone"},
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
    ConfigEntry{FACET_FIELD(frontend.recall_radius_px), "px", 0, 50, "lost landmarks are searched this far from their prediction; 0: never"},
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
    ConfigEntry{FACET_FIELD(window.learn_pixel_sigma), "-", 0, 1, "begin with that value and follow the residuals, up to a factor of ten"},
    ConfigEntry{FACET_FIELD(window.loss_threshold), "-", 0.2, 10, "of Cauchy's loss, in root mean squares of the residuals"},
    ConfigEntry{FACET_FIELD(window.redundant_px), "px", 0, 100, "keyframes that moved less from the one before are dropped first; 0: never"},
    ConfigEntry{FACET_FIELD(window.outlier_threshold_px), "px", 0.5, 20, "observations farther off after optimization are removed"},
    ConfigEntry{FACET_FIELD(regularity.sigma_m), "m", 1e-3, 0.5, "how flat planes are: standard deviation of a landmark from its plane"},
    ConfigEntry{FACET_FIELD(regularity.huber_threshold), "-", 0.5, 10, "robust loss on whitened heights above a plane"},
    ConfigEntry{FACET_FIELD(regularity.min_constraints), "-", 6, 256, "landmarks that bring a plane in"},
    ConfigEntry{FACET_FIELD(regularity.keep_constraints), "-", 3, 256, "with fewer a new plane leaves again"},
    ConfigEntry{FACET_FIELD(regularity.min_extent_m), "m", 0.01, 10, "least spread of these, rms, along the plane's narrower side"},
    ConfigEntry{FACET_FIELD(regularity.join_sigmas), "-", 0.5, 10, "a landmark nearer than this to a plane joins it"},
    ConfigEntry{FACET_FIELD(regularity.leave_sigmas), "-", 0.5, 20, "one farther leaves"},
    ConfigEntry{FACET_FIELD(regularity.max_plane_chi2), "-", 1, 100, "mean squared height of a plane's landmarks that says it is none"},
    ConfigEntry{FACET_FIELD(regularity.use_pairs), "-", 0, 1, "parallel and orthogonal planes as constraints"},
    ConfigEntry{FACET_FIELD(regularity.use_gravity), "-", 0, 1, "level floors and upright walls as constraints"},
    ConfigEntry{FACET_FIELD(regularity.pair_sigma_deg), "deg", 0.01, 10, "how exact buildings are"},
    ConfigEntry{FACET_FIELD(regularity.pair_gate_deg), "deg", 0.1, 20, "pairs nearer than this to parallel or orthogonal are taken for it"},
    ConfigEntry{FACET_FIELD(calibration.estimate_time_offset), "-", 0, 1, "estimate the time between the cameras' clock and the IMU's"},
    ConfigEntry{FACET_FIELD(calibration.time_offset_sigma_s), "s", 1e-6, 0.1, "prior of the time offset"},
    ConfigEntry{FACET_FIELD(calibration.estimate_extrinsics), "-", 0, 1, "estimate the place of the camera pair on the body"},
    ConfigEntry{FACET_FIELD(calibration.rotation_sigma_rad), "rad", 1e-6, 0.2, "prior of the pair's rotation"},
    ConfigEntry{FACET_FIELD(calibration.translation_sigma_m), "m", 1e-6, 0.2, "prior of the pair's place"},
    ConfigEntry{FACET_FIELD(stationarity.duration_s), "s", 0.1, 5, "stretch of inertial data looked at for standing still"},
    ConfigEntry{FACET_FIELD(stationarity.margin), "-", 1, 20, "deviations may be this many times the sensor's noise and the floor"},
    ConfigEntry{FACET_FIELD(stationarity.gyro_floor_rad_per_s), "rad/s", 0, 0.5, "shaking of a vehicle at rest"},
    ConfigEntry{FACET_FIELD(stationarity.accel_floor_m_per_s2), "m/s^2", 0, 5, "shaking of a vehicle at rest"},
    ConfigEntry{FACET_FIELD(stationarity.gyro_mean_rad_per_s), "rad/s", 1e-4, 0.5, "mean rate at rest without bias"},
    ConfigEntry{FACET_FIELD(stationarity.gravity_error_m_per_s2), "m/s^2", 0.01, 3, "mean acceleration at rest is this close to g"},
    ConfigEntry{FACET_FIELD(stationarity.gyro_drift_rad_per_s), "rad/s", 0, 0.1, "change between the halves of the stretch beyond noise"},
    ConfigEntry{FACET_FIELD(stationarity.accel_drift_m_per_s2), "m/s^2", 0, 1, "change between the halves of the stretch beyond noise"},
    ConfigEntry{FACET_FIELD(health.few_features), "-", 4, 100, "fewer tracked features do not hold a pose"},
    ConfigEntry{FACET_FIELD(health.lost_after_s), "s", 0.2, 30, "without vision for longer: lost"},
    ConfigEntry{FACET_FIELD(health.max_speed_m_per_s), "m/s", 1, 100, "faster is divergence"},
    ConfigEntry{FACET_FIELD(health.max_velocity_sigma_m_per_s), "m/s", 0.05, 10, "a velocity less sure than this is none"},
    ConfigEntry{FACET_FIELD(health.max_gyro_bias_rad_per_s), "rad/s", 0.01, 5, "larger is divergence"},
    ConfigEntry{FACET_FIELD(health.max_accel_bias_m_per_s2), "m/s^2", 0.1, 10, "larger is divergence"},
    ConfigEntry{FACET_FIELD(health.high_vision_chi2), "-", 1, 100, "squared residual per degree of freedom: degraded"},
    ConfigEntry{FACET_FIELD(health.wrong_vision_chi2), "-", 2, 1000, "likewise at three keyframes in a row: lost"},
    ConfigEntry{FACET_FIELD(health.ready_velocity_sigma_m_per_s), "m/s", 0.01, 1, "a start is over when velocity is known this well"},
    ConfigEntry{FACET_FIELD(health.ready_tilt_sigma_rad), "rad", 0.001, 0.5, "and the direction of gravity"},
    ConfigEntry{FACET_FIELD(health.grace_s), "s", 0, 30, "quality stays low for this long after a start"},
    ConfigEntry{FACET_FIELD(health.vibration_m_per_s2), "m/s^2", 0.1, 100, "shaking of the accelerometer worth a warning"},
    ConfigEntry{FACET_FIELD(health.auto_reset), "-", 0, 1, "begin anew, in flight, when lost and images are back"},
    ConfigEntry{FACET_FIELD(imu_limits.gyro_range_rad_per_s), "rad/s", 0.1, 1000, "full scale of a gyroscope axis"},
    ConfigEntry{FACET_FIELD(imu_limits.accel_range_m_per_s2), "m/s^2", 5, 1e5, "full scale of an accelerometer axis"},
    ConfigEntry{FACET_FIELD(imu_noise.gyro_noise_rad_per_s_per_sqrt_hz), "rad/s/sqrt(Hz)", 1e-7, 1, "gyro white noise; the calibration's unless given"},
    ConfigEntry{FACET_FIELD(imu_noise.gyro_walk_rad_per_s2_per_sqrt_hz), "rad/s^2/sqrt(Hz)", 1e-9, 1, "gyro bias walk; the calibration's unless given"},
    ConfigEntry{FACET_FIELD(imu_noise.accel_noise_m_per_s2_per_sqrt_hz), "m/s^2/sqrt(Hz)", 1e-6, 10, "accelerometer white noise; the calibration's unless given"},
    ConfigEntry{FACET_FIELD(imu_noise.accel_walk_m_per_s3_per_sqrt_hz), "m/s^3/sqrt(Hz)", 1e-8, 10, "accelerometer bias walk; the calibration's unless given"},
    ConfigEntry{FACET_FIELD(imu_noise.rate_hz), "Hz", 20, 10000, "nominal rate of the IMU; the calibration's unless given"},
    ConfigEntry{FACET_FIELD(mesh.max_depth_m), "m", 0.5, 100, "landmarks farther from the keyframe give no new face"},
    ConfigEntry{FACET_FIELD(mesh.max_depth_sigma_m), "m", 1e-3, 10, "landmarks less certain along the ray give none either"},
    ConfigEntry{FACET_FIELD(mesh.max_chi2), "-", 0.1, 1000, "nor those whose sightings contradict each other more"},
    ConfigEntry{FACET_FIELD(mesh.use_stereo_points), "-", 0, 1, "also landmarks that only one stereo match gives"},
    ConfigEntry{FACET_FIELD(mesh.recent_keyframes), "-", 0, 32, "landmarks unseen for up to this many keyframes also give faces"},
    ConfigEntry{FACET_FIELD(mesh.recent_distance_px), "px", 0, 200, "but not nearer to other points in the image"},
    ConfigEntry{FACET_FIELD(mesh.min_side_ratio), "-", 0, 1, "least shortest over longest side of a face"},
    ConfigEntry{FACET_FIELD(mesh.min_elongation), "-", 0, 10, "least extent of a face across the ray over that along it"},
    ConfigEntry{FACET_FIELD(mesh.max_side_m), "m", 0.05, 100, "longest side of a face"},
    ConfigEntry{FACET_FIELD(mesh.max_flat_side_m), "m", 0.05, 100, "the same for a face with two neighbours in its plane"},
    ConfigEntry{FACET_FIELD(mesh.max_grazing_deg), "deg", 1, 90, "largest angle between a face's normal and the ray"},
    ConfigEntry{FACET_FIELD(mesh.step_sigmas), "-", 0, 20, "a depth step counts beyond this many standard deviations"},
    ConfigEntry{FACET_FIELD(mesh.max_step_slope), "-", 0.1, 100, "largest depth step over lateral distance along a side"},
    ConfigEntry{FACET_FIELD(mesh.gradient_step_slope), "-", 0.1, 100, "the same where the side crosses a strong image gradient"},
    ConfigEntry{FACET_FIELD(mesh.strong_gradient), "-", 1, 255, "grey levels over two pixels that are a strong gradient"},
    ConfigEntry{FACET_FIELD(mesh.coplanar_m), "m", 0, 1, "a steep face stays if its neighbours are in its plane this closely"},
    ConfigEntry{FACET_FIELD(mesh.lonely_side_m), "m", 0.05, 100, "a face with a longer side needs neighbours in its plane"},
    ConfigEntry{FACET_FIELD(mesh.lonely_neighbours), "-", 0, 3, "so many of them"},
    ConfigEntry{FACET_FIELD(mesh.conflict_margin_m), "m", 0, 10, "a face this far in front of a tracked point is contradicted"},
    ConfigEntry{FACET_FIELD(mesh.min_contradictions), "-", 1, 1000, "contradictions that a face may leave for"},
    ConfigEntry{FACET_FIELD(mesh.hole_planarity_m), "m", 0, 1, "a hole is filled if its ring is in a plane this closely"},
    ConfigEntry{FACET_FIELD(planes.face_angle_deg), "deg", 0.5, 30, "a face may be turned this far from its plane, beyond two sigma"},
    ConfigEntry{FACET_FIELD(planes.max_face_angle_deg), "deg", 1, 60, "but never farther"},
    ConfigEntry{FACET_FIELD(planes.max_face_area_m2), "m^2", 0.01, 10, "a larger face has no more votes"},
    ConfigEntry{FACET_FIELD(planes.min_support_m2), "m^2", 0.01, 100, "least votes of a candidate"},
    ConfigEntry{FACET_FIELD(planes.search_gate_m), "m", 0.02, 1, "landmarks this near to a candidate take part in its first fit"},
    ConfigEntry{FACET_FIELD(planes.join_m), "m", 0.005, 0.5, "a landmark joins a plane within this"},
    ConfigEntry{FACET_FIELD(planes.join_sigmas), "-", 0.5, 10, "and within this many standard deviations"},
    ConfigEntry{FACET_FIELD(planes.stay_m), "m", 0.005, 1, "a landmark leaves its plane beyond this"},
    ConfigEntry{FACET_FIELD(planes.stay_sigmas), "-", 0.5, 20, "or beyond so many standard deviations"},
    ConfigEntry{FACET_FIELD(planes.max_point_sigma_m), "m", 0.005, 1, "landmarks less certain across the plane are left out"},
    ConfigEntry{FACET_FIELD(planes.surface_sigma_m), "m", 0.001, 0.1, "how flat real surfaces are"},
    ConfigEntry{FACET_FIELD(planes.max_tilt_deg), "deg", 0.1, 20, "of a floor from level, of a wall from upright"},
    ConfigEntry{FACET_FIELD(planes.min_landmarks), "-", 4, 256, "of a new plane"},
    ConfigEntry{FACET_FIELD(planes.min_area_m2), "m^2", 0.01, 100, "covered by the faces of a new plane"},
    ConfigEntry{FACET_FIELD(planes.min_extent_m), "m", 0.01, 10, "standard deviation of its landmarks along its shorter side"},
    ConfigEntry{FACET_FIELD(planes.max_chi2), "-", 0.5, 100, "squared whitened residual per degree of freedom"},
    ConfigEntry{FACET_FIELD(planes.max_bend_m), "m", 0.001, 1, "rms of the best quadratic surface against the plane"},
    ConfigEntry{FACET_FIELD(planes.max_roughness_m), "m", 0.001, 1, "rms of what neighbouring residuals have in common"},
    ConfigEntry{FACET_FIELD(planes.min_coherence), "-", 0, 1, "share of the faces with two corners on it whose third is so too"},
    ConfigEntry{FACET_FIELD(planes.same_angle_deg), "deg", 0.1, 30, "planes turned farther are never the same"},
    ConfigEntry{FACET_FIELD(planes.same_distance_m), "m", 0.005, 1, "nor those farther apart at their landmarks"},
    ConfigEntry{FACET_FIELD(planes.confirm_keyframes), "-", 1, 20, "a plane is told when found at this many keyframes"},
    ConfigEntry{FACET_FIELD(planes.leave_keyframes), "-", 1, 100, "and no more when lost for longer"},
    ConfigEntry{FACET_FIELD(planes.forget_keyframes), "-", 1, 10000, "a plane found again within so many is the old one"},
};
// clang-format on

#undef FACET_FIELD

}  // namespace

std::span<const ConfigEntry> config_table() { return kTable; }

double config_value(const ConfigEntry& entry, const ProgramConfig& config) {
    ProgramConfig copy = config;
    return std::visit([&](auto* field) { return static_cast<double>(field(copy)); }, entry.field);
}

const ConfigEntry* find_out_of_range(const ProgramConfig& config) {
    for (const ConfigEntry& entry : kTable) {
        const double value = config_value(entry, config);
        if (!(value >= entry.min && value <= entry.max)) {
            return &entry;
        }
    }
    return nullptr;
}

}  // namespace facet
