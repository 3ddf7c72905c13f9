// SPDX-License-Identifier: BSD-2-Clause
#include "app/calibration/calibration_fields.h"

#include <fmt/core.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>

#include "platform/base/angle.h"
#include "platform/base/range_check.h"

namespace facet {
namespace {

constexpr double kOrthonormalTolerance = 1e-3;
constexpr double kMinBaselineM = 1e-3;
constexpr double kMaxBaselineM = 10.0;
constexpr std::size_t kCoefficients = 4;
constexpr double kMaxSide_px = 16384.0;
// Focal lengths in longer sides of the image: from wider than any fisheye to a telescope of 3 degrees.
constexpr double kMinFocal = 0.1;
constexpr double kMaxFocal = 20.0;

Distortion read_distortion(const YamlNode& field) {
    const std::string name = field.text();
    if (name == "radial-tangential" || name == "radtan" || name == "plumb_bob") {
        return Distortion::kRadialTangential;
    }
    if (name == "equidistant") {
        return Distortion::kEquidistant;
    }
    if (name == "none") {
        return Distortion::kNone;
    }
    field.fail(fmt::format("unknown model '{}': radial-tangential (radtan), equidistant or none", name));
}

/// A figure of the IMU, within the range of the parameter that it becomes.
void read_noise(const YamlNode& node, double ImuNoise::*member, ImuNoise& noise) {
    const auto* const field =
        std::ranges::find(kImuNoiseFields, ParameterField<ImuNoise>::Member(member), &ParameterField<ImuNoise>::member);
    noise.*member = node.number();
    node.require_in_range(noise.*member, field->min, field->max, field->unit);
}

/// Names the first field that makes CameraModel::validate refuse.
[[noreturn]] void fail_camera(const YamlNode& camera, const CameraIntrinsics& k, const std::string& coefficients_key) {
    if (k.distortion != Distortion::kNone) {
        CameraIntrinsics undistorted = k;
        undistorted.distortion = Distortion::kNone;
        undistorted.coeffs = {};
        if (ok(CameraModel::validate(undistorted))) {
            camera.at(coefficients_key).fail("distortion is not increasing up to the image corner");
        }
    }
    camera.at("intrinsics").fail("not a usable pinhole camera for this resolution");
}

bool states_sigmas(const YamlNode& camera) {
    return camera.has("intrinsics_sigma") && camera.has("distortion_sigma") && camera.has("rotation_sigma_deg");
}

}  // namespace

Se3 read_transform(const YamlNode& field) {
    const Eigen::Matrix4d t = field.matrix4();
    if (!t.row(3).isApprox(Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0), 1e-9)) {
        field.fail("last row must be 0 0 0 1");
    }
    const Eigen::Matrix3d r = t.topLeftCorner<3, 3>();
    const double error = (r.transpose() * r - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
    if (error > kOrthonormalTolerance) {
        field.fail(fmt::format("rotation is not orthonormal: off by {:.2g}, allowed {}", error, kOrthonormalTolerance));
    }
    if (r.determinant() < 0.0) {
        field.fail("rotation is a reflection (determinant -1)");
    }
    // Nearest rotation in the Frobenius norm: U V^T of the singular value decomposition.
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(r, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Eigen::Matrix3d nearest = svd.matrixU() * svd.matrixV().transpose();
    return {Eigen::Quaterniond(nearest).normalized(), t.topRightCorner<3, 1>()};
}

CameraModel read_camera(const YamlNode& camera, const std::string& coefficients_key) {
    const YamlNode model = camera.at("camera_model");
    if (model.text() != "pinhole") {
        model.fail(fmt::format("unknown model '{}': only pinhole is supported", model.text()));
    }
    CameraIntrinsics k;
    const YamlNode resolution = camera.at("resolution");
    const std::vector<double> size = resolution.numbers(2);
    if (std::ranges::any_of(size, [](double x) { return !(x >= 1.0 && x <= kMaxSide_px) || x != std::floor(x); })) {
        resolution.fail("must be two positive integers");
    }
    k.width = static_cast<int>(size[0]);
    k.height = static_cast<int>(size[1]);
    const YamlNode intrinsics = camera.at("intrinsics");
    const std::vector<double> f = intrinsics.numbers(4);
    if (f[0] <= 0.0 || f[1] <= 0.0) {
        intrinsics.fail("focal lengths must be positive");
    }
    const double side = std::max(size[0], size[1]);
    if (std::min(f[0], f[1]) < kMinFocal * side || std::max(f[0], f[1]) > kMaxFocal * side) {
        intrinsics.fail(
            fmt::format("focal lengths of {:.4g} and {:.4g} px do not belong to {}x{} px: must be {:.4g} to {:.4g}",
                        f[0], f[1], k.width, k.height, kMinFocal * side, kMaxFocal * side));
    }
    if (!in_range(f[2], -size[0], 2.0 * size[0]) || !in_range(f[3], -size[1], 2.0 * size[1])) {
        intrinsics.fail("the principal point is more than an image away from the image");
    }
    k.fx = f[0];
    k.fy = f[1];
    k.cx = f[2];
    k.cy = f[3];
    k.distortion = read_distortion(camera.at("distortion_model"));
    if (k.distortion != Distortion::kNone) {
        const std::vector<double> c = camera.at(coefficients_key).numbers(kCoefficients);
        k.coeffs = {c[0], c[1], c[2], c[3]};
    }
    if (!ok(CameraModel::validate(k))) {
        fail_camera(camera, k, coefficients_key);
    }
    return CameraModel(k);
}

ImuNoise read_imu_noise(const YamlNode& imu, const std::string& rate_key) {
    ImuNoise noise;
    read_noise(imu.at("gyroscope_noise_density"), &ImuNoise::gyro_noise_rad_per_s_per_sqrt_hz, noise);
    read_noise(imu.at("gyroscope_random_walk"), &ImuNoise::gyro_walk_rad_per_s2_per_sqrt_hz, noise);
    read_noise(imu.at("accelerometer_noise_density"), &ImuNoise::accel_noise_m_per_s2_per_sqrt_hz, noise);
    read_noise(imu.at("accelerometer_random_walk"), &ImuNoise::accel_walk_m_per_s3_per_sqrt_hz, noise);
    read_noise(imu.at(rate_key), &ImuNoise::rate_hz, noise);
    return noise;
}

void check_baseline(const StereoRig& rig, const YamlNode& right_extrinsics) {
    const double baseline = rig.baseline_m();
    if (!in_range(baseline, kMinBaselineM, kMaxBaselineM)) {
        right_extrinsics.fail(fmt::format("baseline between the cameras is {:.4g} m, must be {} to {} m", baseline,
                                          kMinBaselineM, kMaxBaselineM));
    }
}

std::optional<StatedSigmas> read_stated_sigmas(const YamlNode& left, const YamlNode& right) {
    if (!states_sigmas(left) || !states_sigmas(right)) {
        return std::nullopt;
    }
    StatedSigmas largest;
    for (const YamlNode& camera : std::array{left, right}) {
        const std::vector<double> f = camera.at("intrinsics").numbers(4);
        const std::vector<double> lens = camera.at("intrinsics_sigma").numbers(4);
        const std::vector<double> distortion = camera.at("distortion_sigma").numbers(4);
        const std::vector<double> turn = camera.at("rotation_sigma_deg").numbers(3);
        largest.focal = std::max({largest.focal, lens[0] / f[0], lens[1] / f[1]});
        largest.principal_px = std::max({largest.principal_px, lens[2], lens[3]});
        largest.distortion = std::max({largest.distortion, distortion[0], distortion[1]});
        largest.late_distortion = std::max({largest.late_distortion, distortion[2], distortion[3]});
        largest.rotation_rad = std::max(largest.rotation_rad, kRadPerDeg * *std::max_element(turn.begin(), turn.end()));
    }
    return largest;
}

}  // namespace facet
