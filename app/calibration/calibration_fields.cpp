// SPDX-License-Identifier: BSD-2-Clause
#include "app/calibration/calibration_fields.h"

#include <fmt/core.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "platform/base/angle.h"
#include "platform/base/range_check.h"

namespace facet {
namespace {

constexpr double kOrthonormalTolerance = 1e-3;
constexpr double kMinBaselineM = 1e-3;
constexpr double kMaxBaselineM = 10.0;
constexpr double kMaxTimeShiftS = 1.0;
constexpr double kMaxSide_px = 16384.0;
// Focal lengths in longer sides of the image: from wider than any fisheye to a telescope of 3 degrees.
constexpr double kMinFocal = 0.1;
constexpr double kMaxFocal = 20.0;

bool is_one_of(const std::string& name, std::initializer_list<std::string_view> names) {
    return std::ranges::find(names, name) != names.end();
}

/// OpenCV's order: k1 k2 p1 p2 k3 k4 k5 k6. A lens whose later coefficients are zero is the plain one.
void set_radial_tangential(const LensFields& lens, CameraIntrinsics& k) {
    const std::vector<double>& c = lens.coefficients;
    const auto is_zero_from = [&](std::size_t first) {
        return std::all_of(c.begin() + static_cast<std::ptrdiff_t>(std::min(first, c.size())), c.end(),
                           [](double x) { return x == 0.0; });
    };
    if (c.size() != 4 && c.size() != 5 && c.size() != 8 && c.size() != 12 && c.size() != 14) {
        lens.coefficients_node.fail("must be a list of 4, 5 or 8 numbers: k1 k2 p1 p2 (k3 (k4 k5 k6))");
    }
    if (!is_zero_from(8)) {
        lens.coefficients_node.fail("a thin prism or a tilted sensor, coefficients 9 and on, is not modelled");
    }
    k.coeffs = {c[0], c[1], c[2], c[3]};
    k.distortion = Distortion::kRadialTangential;
    if (!is_zero_from(4)) {
        k.distortion = Distortion::kRational;
        std::copy(c.begin() + 4, c.begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(c.size(), 8)),
                  k.more.begin());
    }
}

void set_coefficients(const LensFields& lens, std::size_t count, Distortion distortion, CameraIntrinsics& k) {
    if (lens.coefficients.size() != count) {
        lens.coefficients_node.fail(fmt::format("must be a list of {} numbers", count));
    }
    std::ranges::copy(lens.coefficients, k.coeffs.begin());
    k.distortion = distortion;
}

/// Of a pinhole.
void set_distortion(const LensFields& lens, CameraIntrinsics& k) {
    const std::string& name = lens.distortion;
    if (is_one_of(name, {"radial-tangential", "radtan", "radialtangential", "plumb_bob", "rational_polynomial",
                         "rational", "radialtangential8", "pinhole-radtan8", "radtan8"})) {
        set_radial_tangential(lens, k);
    } else if (is_one_of(name, {"equidistant", "equi", "fisheye", "kannala_brandt", "kb4"})) {
        set_coefficients(lens, 4, Distortion::kEquidistant, k);
    } else if (is_one_of(name, {"fov", "atan"})) {
        set_coefficients(lens, 1, Distortion::kFov, k);
    } else if (!is_one_of(name, {"none", ""})) {
        lens.distortion_node.fail(
            fmt::format("unknown model '{}': radial-tangential (radtan, plumb_bob; 4, 5 or 8 coefficients), "
                        "equidistant (fisheye), fov or none",
                        name));
    }
}

/// Of the models with parameters of their own before the focal lengths. @return how many, or none for a pinhole
std::size_t set_projection(const LensFields& lens, CameraIntrinsics& k) {
    const std::vector<double>& f = lens.intrinsics;
    const auto need = [&](std::size_t own) {
        if (f.size() != own + 4) {
            lens.intrinsics_node.fail(fmt::format("must be a list of {} numbers", own + 4));
        }
        return own;
    };
    const auto refuse_distortion = [&] {
        if (!is_one_of(lens.distortion, {"none", ""})) {
            lens.distortion_node.fail(fmt::format("camera model {} has no distortion of its own", lens.model));
        }
    };
    if (is_one_of(lens.model, {"pinhole"})) {
        need(0);
        set_distortion(lens, k);
        return 0;
    }
    if (is_one_of(lens.model, {"omni", "mei", "MEI", "unified"})) {
        need(1);
        if (is_one_of(lens.distortion, {"none", ""})) {
            k.coeffs = {};
        } else if (is_one_of(lens.distortion, {"radtan", "radial-tangential", "plumb_bob"})) {
            set_coefficients(lens, 4, Distortion::kUnified, k);
        } else {
            lens.distortion_node.fail(fmt::format("omni with '{}': only radtan or none", lens.distortion));
        }
        k.distortion = Distortion::kUnified;
        k.more[0] = f[0];
        return 1;
    }
    if (is_one_of(lens.model, {"ds", "double_sphere", "double-sphere", "eucm"})) {
        need(2);
        refuse_distortion();
        k.distortion = lens.model == "eucm" ? Distortion::kEucm : Distortion::kDoubleSphere;
        k.coeffs = {f[0], f[1], 0.0, 0.0};
        return 2;
    }
    lens.model_node.fail(fmt::format("unknown model '{}': pinhole, omni, ds or eucm", lens.model));
}

/// Names the first field that makes CameraModel::validate refuse.
[[noreturn]] void fail_camera(const LensFields& lens, const CameraIntrinsics& k) {
    if (k.distortion != Distortion::kNone) {
        CameraIntrinsics undistorted = k;
        undistorted.distortion = Distortion::kNone;
        undistorted.coeffs = {};
        if (ok(CameraModel::validate(undistorted)) && !lens.coefficients.empty()) {
            lens.coefficients_node.fail("distortion is not increasing up to the image corner");
        }
    }
    lens.intrinsics_node.fail(fmt::format("not a usable {} camera for this resolution", lens.model));
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
    return {Eigen::Quaterniond(nearest_rotation(t.topLeftCorner<3, 3>(), field)).normalized(),
            t.topRightCorner<3, 1>()};
}

Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& r, const YamlNode& field) {
    const double error = (r.transpose() * r - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
    if (error > kOrthonormalTolerance) {
        field.fail(fmt::format("rotation is not orthonormal: off by {:.2g}, allowed {}", error, kOrthonormalTolerance));
    }
    if (r.determinant() < 0.0) {
        field.fail("rotation is a reflection (determinant -1)");
    }
    // Nearest rotation in the Frobenius norm: U V^T of the singular value decomposition.
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(r, Eigen::ComputeFullU | Eigen::ComputeFullV);
    return svd.matrixU() * svd.matrixV().transpose();
}

CameraModel make_camera(const LensFields& lens) {
    const std::vector<double>& size = lens.resolution;
    if (size.size() != 2 ||
        std::ranges::any_of(size, [](double x) { return !(x >= 1.0 && x <= kMaxSide_px) || x != std::floor(x); })) {
        lens.resolution_node.fail("must be two positive integers");
    }
    CameraIntrinsics k;
    k.width = static_cast<int>(size[0]);
    k.height = static_cast<int>(size[1]);
    const std::size_t first = set_projection(lens, k);
    k.fx = lens.intrinsics[first];
    k.fy = lens.intrinsics[first + 1];
    k.cx = lens.intrinsics[first + 2];
    k.cy = lens.intrinsics[first + 3];
    const YamlNode& intrinsics = lens.intrinsics_node;
    if (k.fx <= 0.0 || k.fy <= 0.0) {
        intrinsics.fail("focal lengths must be positive");
    }
    const double side = std::max(size[0], size[1]);
    if (std::min(k.fx, k.fy) < kMinFocal * side || std::max(k.fx, k.fy) > kMaxFocal * side) {
        intrinsics.fail(
            fmt::format("focal lengths of {:.4g} and {:.4g} px do not belong to {}x{} px: must be {:.4g} to {:.4g}",
                        k.fx, k.fy, k.width, k.height, kMinFocal * side, kMaxFocal * side));
    }
    if (!in_range(k.cx, -size[0], 2.0 * size[0]) || !in_range(k.cy, -size[1], 2.0 * size[1])) {
        intrinsics.fail("the principal point is more than an image away from the image");
    }
    if (!ok(CameraModel::validate(k))) {
        fail_camera(lens, k);
    }
    return CameraModel(k);
}

CameraModel read_camera(const YamlNode& camera, const std::string& coefficients_key) {
    const YamlNode model = camera.at("camera_model");
    const YamlNode resolution = camera.at("resolution");
    const YamlNode intrinsics = camera.at("intrinsics");
    const bool may_lack_distortion = model.text() != "pinhole";  // some models have none
    const bool has_distortion = camera.has("distortion_model") || !may_lack_distortion;
    const YamlNode distortion = has_distortion ? camera.at("distortion_model") : model;
    const std::string name = has_distortion ? distortion.text() : "none";
    const bool has_coefficients = name != "none" && !name.empty();
    const YamlNode coefficients = has_coefficients ? camera.at(coefficients_key) : distortion;
    return make_camera({.model = model.text(),
                        .distortion = name,
                        .intrinsics = intrinsics.numbers(),
                        .coefficients = has_coefficients ? coefficients.numbers() : std::vector<double>{},
                        .resolution = resolution.numbers(2),
                        .model_node = model,
                        .distortion_node = distortion,
                        .intrinsics_node = intrinsics,
                        .coefficients_node = coefficients,
                        .resolution_node = resolution});
}

Duration read_time_shift(const YamlNode& node, const std::string& key, double unit_s) {
    if (!node.has(key)) {
        return {};
    }
    const YamlNode field = node.at(key);
    const double shift_s = unit_s * field.number();
    if (shift_s < -kMaxTimeShiftS || shift_s > kMaxTimeShiftS) {
        field.fail("more than 1 s: cameras and IMU are not on one clock");
    }
    return Duration::from_seconds(shift_s);
}

void remark_unused(const YamlNode& node, std::initializer_list<std::string_view> used,
                   std::vector<std::string>& remarks) {
    if (!node.raw().IsMap()) {
        return;
    }
    for (const auto& entry : node.raw()) {
        const std::string& name = entry.first.Scalar();  // empty if the key is no text
        if (!name.empty() && std::ranges::find(used, name) == used.end()) {
            const YamlNode field = node.at(name);
            remarks.push_back(fmt::format("{}:{}: {}: is not used", field.file(), field.line(), field.field()));
        }
    }
}

void check_baseline(const StereoRig& rig, const YamlNode& right_extrinsics) {
    const double baseline = rig.baseline_m();
    if (!in_range(baseline, kMinBaselineM, kMaxBaselineM)) {
        right_extrinsics.fail(fmt::format("baseline between the cameras is {:.4g} m, must be {} to {} m", baseline,
                                          kMinBaselineM, kMaxBaselineM));
    }
}

std::optional<StatedSigmas> read_stated_sigmas(const YamlNode& left, const YamlNode& right, const StereoRig& rig) {
    if (!states_sigmas(left) || !states_sigmas(right)) {
        return std::nullopt;
    }
    StatedSigmas largest;
    for (const bool is_left : {true, false}) {
        const YamlNode& camera = is_left ? left : right;
        const CameraIntrinsics& k = (is_left ? rig.left : rig.right).intrinsics();
        const std::vector<double> lens = camera.at("intrinsics_sigma").numbers(4);
        const std::vector<double> distortion = camera.at("distortion_sigma").numbers(4);
        const std::vector<double> turn = camera.at("rotation_sigma_deg").numbers(3);
        largest.focal = std::max({largest.focal, lens[0] / k.fx, lens[1] / k.fy});
        largest.principal_px = std::max({largest.principal_px, lens[2], lens[3]});
        largest.distortion = std::max({largest.distortion, distortion[0], distortion[1]});
        largest.late_distortion = std::max({largest.late_distortion, distortion[2], distortion[3]});
        largest.rotation_rad = std::max(largest.rotation_rad, kRadPerDeg * *std::max_element(turn.begin(), turn.end()));
    }
    return largest;
}

}  // namespace facet
