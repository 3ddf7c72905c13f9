// SPDX-License-Identifier: BSD-2-Clause
#include "app/calibration/other_cameras.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "app/calibration/calibration_fields.h"
#include "app/calibration/imu_fields.h"

namespace facet {
namespace {

/// Figures of an IMU under the names of a format.
struct NoiseKeys {
    const char* gyro;
    const char* gyro_walk;
    const char* accel;
    const char* accel_walk;
    const char* rate;
};

/// The first of a list, or the number itself.
YamlNode first_of(const YamlNode& node) { return node.raw().IsSequence() ? node.item(0) : node; }

ImuFigures read_noise_as(const YamlNode& imu, const NoiseKeys& keys, ImuNoise& noise) {
    read_noise(first_of(imu.at(keys.gyro)), &ImuNoise::gyro_noise_rad_per_s_per_sqrt_hz, noise);
    read_noise(first_of(imu.at(keys.gyro_walk)), &ImuNoise::gyro_walk_rad_per_s2_per_sqrt_hz, noise);
    read_noise(first_of(imu.at(keys.accel)), &ImuNoise::accel_noise_m_per_s2_per_sqrt_hz, noise);
    read_noise(first_of(imu.at(keys.accel_walk)), &ImuNoise::accel_walk_m_per_s3_per_sqrt_hz, noise);
    if (imu.has(keys.rate)) {
        read_noise(imu.at(keys.rate), &ImuNoise::rate_hz, noise);
    }
    return {true, imu.has(keys.rate)};
}

/// Puts the cameras in their places. @param right  nullptr: there is none
void set_rig(const CameraModel& left, const Se3& T_B_C0, const CameraModel* right, const Se3& T_B_C1,
             const YamlNode& right_extrinsics, Calibration& calibration) {
    if (right == nullptr) {
        calibration.rig = StereoRig::monocular(left, T_B_C0);
        return;
    }
    calibration.rig = {.left = left, .right = *right, .T_B_C0 = T_B_C0, .T_B_C1 = T_B_C1};
    check_baseline(calibration.rig, right_extrinsics);
}

std::vector<double> numbers_at(const YamlNode& node, std::initializer_list<const char*> keys) {
    std::vector<double> values;
    for (const char* key : keys) {
        values.push_back(node.at(key).number());
    }
    return values;
}

Se3 basalt_pose(const YamlNode& node) {
    const std::vector<double> p = numbers_at(node, {"px", "py", "pz"});
    const std::vector<double> q = numbers_at(node, {"qw", "qx", "qy", "qz"});
    const Eigen::Quaterniond rotation(q[0], q[1], q[2], q[3]);
    if (!(std::abs(rotation.norm() - 1.0) < 1e-2)) {
        node.fail("the quaternion is not of unit length");
    }
    return {rotation.normalized(), {p[0], p[1], p[2]}};
}

CameraModel basalt_camera(const YamlNode& camera, const YamlNode& size) {
    const YamlNode type = camera.at("camera_type");
    const YamlNode k = camera.at("intrinsics");
    const std::vector<double> plane = numbers_at(k, {"fx", "fy", "cx", "cy"});
    LensFields lens{.model = "pinhole",
                    .distortion = "none",
                    .intrinsics = {},
                    .coefficients = {},
                    .resolution = size.numbers(2),
                    .model_node = type,
                    .distortion_node = type,
                    .intrinsics_node = k,
                    .coefficients_node = k,
                    .resolution_node = size};
    const std::string name = type.text();
    if (name == "ds") {
        lens.model = "ds";
        lens.intrinsics = numbers_at(k, {"xi", "alpha"});
    } else if (name == "eucm") {
        lens.model = "eucm";
        lens.intrinsics = numbers_at(k, {"alpha", "beta"});
    } else if (name == "ucm") {
        lens.model = "eucm";
        lens.intrinsics = {k.at("alpha").number(), 1.0};
    } else if (name == "kb4") {
        lens.distortion = "kb4";
        lens.coefficients = numbers_at(k, {"k1", "k2", "k3", "k4"});
    } else if (name == "fov") {
        lens.distortion = "fov";
        lens.coefficients = numbers_at(k, {"w"});
    } else if (name == "pinhole-radtan8") {
        lens.distortion = name;
        lens.coefficients = numbers_at(k, {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"});
    } else if (name != "pinhole") {
        type.fail(fmt::format("unknown model '{}': pinhole, pinhole-radtan8, kb4, ds, eucm, ucm or fov", name));
    }
    lens.intrinsics.insert(lens.intrinsics.end(), plane.begin(), plane.end());
    return make_camera(lens);
}

/// Basalt corrects readings, a = (1 + S) a_m, with S lower triangular for the accelerometer: by columns, behind the
/// three numbers of the bias. The model here is the inverse.
ImuModel basalt_imu_model(const YamlNode& value) {
    Eigen::Matrix3d accel = Eigen::Matrix3d::Identity();
    Eigen::Matrix3d gyro = Eigen::Matrix3d::Identity();
    if (value.has("calib_accel_bias")) {
        const std::vector<double> x = value.at("calib_accel_bias").numbers(9);
        Eigen::Matrix3d scale;
        scale << x[3], 0.0, 0.0, x[4], x[6], 0.0, x[5], x[7], x[8];
        accel += scale;
    }
    if (value.has("calib_gyro_bias")) {
        const std::vector<double> x = value.at("calib_gyro_bias").numbers(12);
        gyro += Eigen::Map<const Eigen::Matrix3d>(x.data() + 3);
    }
    return checked_imu_model(accel.inverse(), gyro.inverse(), Eigen::Matrix3d::Zero(), value);
}

/// k1 k2 p1 p2 (k3) or k1 k2 k3 k4 below a prefix; what is not there is zero.
CameraModel orb_camera(const YamlNode& root, const std::string& prefix, const std::string& type) {
    const auto number = [&](const std::string& key, double fallback) {
        return root.has(prefix + key) ? root.at(prefix + key).number() : fallback;
    };
    const YamlNode focal = root.at(prefix + "fx");
    const YamlNode k1 = root.has(prefix + "k1") ? root.at(prefix + "k1") : focal;
    const YamlNode width = root.at("Camera.width");
    LensFields lens{.model = "pinhole",
                    .distortion = "none",
                    .intrinsics = {focal.number(), root.at(prefix + "fy").number(), root.at(prefix + "cx").number(),
                                   root.at(prefix + "cy").number()},
                    .coefficients = {},
                    .resolution = {width.number(), root.at("Camera.height").number()},
                    .model_node = focal,
                    .distortion_node = k1,
                    .intrinsics_node = focal,
                    .coefficients_node = k1,
                    .resolution_node = width};
    if (type == "KannalaBrandt8") {
        lens.distortion = "equidistant";
        lens.coefficients = {number("k1", 0.0), number("k2", 0.0), number("k3", 0.0), number("k4", 0.0)};
    } else if (type == "PinHole" || type == "Pinhole") {
        lens.distortion = "radtan";
        lens.coefficients = {number("k1", 0.0), number("k2", 0.0), number("p1", 0.0), number("p2", 0.0),
                             number("k3", 0.0)};
    } else if (type != "Rectified") {
        root.at("Camera.type").fail(fmt::format("unknown model '{}': PinHole, KannalaBrandt8 or Rectified", type));
    }
    return make_camera(lens);
}

CameraModel camodocal_camera(const std::string& path) {
    const YamlNode root = load_yaml(path);
    const YamlNode type = root.at("model_type");
    const YamlNode plane = root.at("projection_parameters");
    const YamlNode width = root.at("image_width");
    const std::string name = type.text();
    if (name != "PINHOLE" && name != "MEI" && name != "KANNALA_BRANDT") {
        type.fail(fmt::format("unknown model '{}': PINHOLE, MEI or KANNALA_BRANDT", name));
    }
    const bool is_fisheye = name == "KANNALA_BRANDT";
    const bool is_mei = name == "MEI";
    const YamlNode bend = is_fisheye ? plane : root.at("distortion_parameters");
    LensFields lens{.model = is_mei ? "omni" : "pinhole",
                    .distortion = is_fisheye ? "equidistant" : "radtan",
                    .intrinsics = is_mei ? numbers_at(root.at("mirror_parameters"), {"xi"}) : std::vector<double>{},
                    .coefficients = is_fisheye ? numbers_at(plane, {"k2", "k3", "k4", "k5"})
                                               : numbers_at(bend, {"k1", "k2", "p1", "p2"}),
                    .resolution = {width.number(), root.at("image_height").number()},
                    .model_node = type,
                    .distortion_node = type,
                    .intrinsics_node = plane,
                    .coefficients_node = bend,
                    .resolution_node = width};
    const std::vector<double> f = is_fisheye ? numbers_at(plane, {"mu", "mv", "u0", "v0"})
                                  : is_mei   ? numbers_at(plane, {"gamma1", "gamma2", "u0", "v0"})
                                             : numbers_at(plane, {"fx", "fy", "cx", "cy"});
    lens.intrinsics.insert(lens.intrinsics.end(), f.begin(), f.end());
    return make_camera(lens);
}

/// body_T_cam0, or VINS-Mono's extrinsicRotation and extrinsicTranslation: camera to IMU.
Se3 vins_mount(const YamlNode& root) {
    if (root.has("body_T_cam0")) {
        return read_transform(root.at("body_T_cam0"));
    }
    if (!root.has("extrinsicRotation") || !root.has("extrinsicTranslation")) {
        root.fail(
            "is a configuration of VINS without body_T_cam0, or extrinsicRotation and extrinsicTranslation: write "
            "where "
            "the camera sits against the IMU");
    }
    const YamlNode rotation = root.at("extrinsicRotation");
    const std::vector<double> p = root.at("extrinsicTranslation").numbers();
    if (p.size() != 3) {
        root.at("extrinsicTranslation").fail("must be three numbers");
    }
    return {Eigen::Quaterniond(nearest_rotation(rotation.matrix3(), rotation)).normalized(), {p[0], p[1], p[2]}};
}

/// Stereo.T_c1_c2, or Tlr of older files, three rows of four: right camera to left.
Se3 orb_right_to_left(const YamlNode& root) {
    if (root.has("Stereo.T_c1_c2")) {
        return read_transform(root.at("Stereo.T_c1_c2"));
    }
    const YamlNode field = root.at("Tlr");
    const std::vector<double> rows = field.numbers();
    if (rows.size() == 16) {
        return read_transform(field);
    }
    if (rows.size() != 12) {
        field.fail("must be a 3x4 matrix");
    }
    using RowMajor = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;
    const RowMajor T = Eigen::Map<const RowMajor>(rows.data());
    return {Eigen::Quaterniond(nearest_rotation(T.leftCols<3>(), field)).normalized(), T.col(3)};
}

CameraModel okvis_camera(const YamlNode& camera) {
    const YamlNode focal = camera.at("focal_length");
    const YamlNode size = camera.at("image_dimension");
    const YamlNode type = camera.at("distortion_type");
    const YamlNode coefficients = camera.at("distortion_coefficients");
    const std::vector<double> f = focal.numbers(2);
    const std::vector<double> c = camera.at("principal_point").numbers(2);
    return make_camera({.model = "pinhole",
                        .distortion = type.text(),
                        .intrinsics = {f[0], f[1], c[0], c[1]},
                        .coefficients = coefficients.numbers(),
                        .resolution = size.numbers(2),
                        .model_node = type,
                        .distortion_node = type,
                        .intrinsics_node = focal,
                        .coefficients_node = coefficients,
                        .resolution_node = size});
}

}  // namespace

ImuFigures read_basalt(const YamlNode& root, Calibration& calibration) {
    const YamlNode value = root.at("value0");
    const YamlNode poses = value.at("T_imu_cam");
    const YamlNode lenses = value.at("intrinsics");
    const YamlNode sizes = value.at("resolution");
    const bool has_right = poses.size() > 1;
    const CameraModel left = basalt_camera(lenses.item(0), sizes.item(0));
    const CameraModel right = has_right ? basalt_camera(lenses.item(1), sizes.item(1)) : left;
    set_rig(left, basalt_pose(poses.item(0)), has_right ? &right : nullptr,
            has_right ? basalt_pose(poses.item(1)) : Se3{}, poses, calibration);
    if (poses.size() > 2) {
        calibration.remarks.push_back(fmt::format("{}: camera 2 and later ones are not used", root.file()));
    }
    calibration.camera_time_shift = read_time_shift(value, "cam_time_offset_ns", 1e-9);
    if (!value.has("gyro_noise_std")) {
        return {};
    }
    calibration.imu_model = basalt_imu_model(value);
    return read_noise_as(value,
                         {"gyro_noise_std", "gyro_bias_std", "accel_noise_std", "accel_bias_std", "imu_update_rate"},
                         calibration.noise);
}

ImuFigures read_orb_slam(const YamlNode& root, Calibration& calibration) {
    const bool is_numbered = root.has("Camera1.fx");
    const std::string type = root.has("Camera.type") ? root.at("Camera.type").text() : "PinHole";
    const bool has_mount = root.has("IMU.T_b_c1") || root.has("Tbc");
    if (!has_mount) {
        root.fail("is a settings file of ORB-SLAM without an IMU: IMU.T_b_c1 is missing");
    }
    const Se3 T_B_C0 = read_transform(root.at(root.has("IMU.T_b_c1") ? "IMU.T_b_c1" : "Tbc"));
    const CameraModel left = orb_camera(root, is_numbered ? "Camera1." : "Camera.", type);
    if (type == "Rectified" && (root.has("Stereo.b") || root.has("Camera.bf"))) {
        const YamlNode b = root.at(root.has("Stereo.b") ? "Stereo.b" : "Camera.bf");
        const double baseline = root.has("Stereo.b") ? b.number() : b.number() / left.intrinsics().fx;
        set_rig(left, T_B_C0, &left, T_B_C0 * Se3{Eigen::Quaterniond::Identity(), {baseline, 0.0, 0.0}}, b,
                calibration);
    } else if (root.has("Stereo.T_c1_c2") || root.has("Tlr")) {
        const CameraModel right = orb_camera(root, "Camera2.", type);
        set_rig(left, T_B_C0, &right, T_B_C0 * orb_right_to_left(root), root, calibration);
    } else if (root.has("Camera2.fx")) {
        root.fail("Stereo.T_c1_c2: missing: where the right camera sits against the left one");
    } else if (root.has("Camera.bf") || root.has("LEFT.K")) {
        root.fail("is a settings file of ORB-SLAM for rectified images: the lens of the right camera is missing");
    } else {
        set_rig(left, T_B_C0, nullptr, {}, root, calibration);
    }
    if (!root.has("IMU.NoiseGyro")) {
        return {};
    }
    return read_noise_as(root, {"IMU.NoiseGyro", "IMU.GyroWalk", "IMU.NoiseAcc", "IMU.AccWalk", "IMU.Frequency"},
                         calibration.noise);
}

ImuFigures read_vins(const YamlNode& root, Calibration& calibration) {
    const auto lens_of = [&](const char* key) {
        const std::filesystem::path folder = std::filesystem::path(root.file()).parent_path();
        return camodocal_camera((folder / root.at(key).text()).string());
    };
    const Se3 T_B_C0 = vins_mount(root);
    // VINS-Mono's configuration is the lens as well.
    const CameraModel left = root.has("cam0_calib") ? lens_of("cam0_calib") : camodocal_camera(root.file());
    const bool uses_right = !root.has("num_of_cam") || root.at("num_of_cam").integer() > 1;
    if (root.has("cam1_calib") && !uses_right) {
        calibration.remarks.push_back(fmt::format("{}:{}: cam1_calib: is not used, since num_of_cam is 1", root.file(),
                                                  root.at("cam1_calib").line()));
    }
    if (root.has("cam1_calib") && uses_right) {
        const YamlNode extrinsics = root.at("body_T_cam1");
        const CameraModel right = lens_of("cam1_calib");
        set_rig(left, T_B_C0, &right, read_transform(extrinsics), extrinsics, calibration);
    } else {
        set_rig(left, T_B_C0, nullptr, {}, root, calibration);
    }
    calibration.camera_time_shift = read_time_shift(root, "td");
    if (root.has("acc_n")) {
        calibration.remarks.push_back(
            fmt::format("{}:{}: acc_n and its like are weights of VINS, not densities, and are not used", root.file(),
                        root.at("acc_n").line()));
    }
    return {};
}

ImuFigures read_okvis(const YamlNode& root, Calibration& calibration) {
    const YamlNode cameras = root.at("cameras");
    const YamlNode first = cameras.item(0);
    const CameraModel left = okvis_camera(first);
    const Se3 T_B_C0 = read_transform(first.at("T_SC"));
    if (cameras.size() > 1) {
        const YamlNode second = cameras.item(1);
        const CameraModel right = okvis_camera(second);
        set_rig(left, T_B_C0, &right, read_transform(second.at("T_SC")), second.at("T_SC"), calibration);
    } else {
        set_rig(left, T_B_C0, nullptr, {}, root, calibration);
    }
    if (root.has("camera_parameters")) {
        calibration.camera_time_shift = read_time_shift(root.at("camera_parameters"), "image_delay", -1.0);
    }
    for (const char* key : {"imu_parameters", "imu", "imu_params"}) {
        if (root.has(key) && root.at(key).has("sigma_g_c")) {
            return read_noise_as(root.at(key), {"sigma_g_c", "sigma_gw_c", "sigma_a_c", "sigma_aw_c", "rate"},
                                 calibration.noise);
        }
    }
    return {};
}

}  // namespace facet
