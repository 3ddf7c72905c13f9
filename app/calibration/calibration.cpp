// SPDX-License-Identifier: BSD-2-Clause
#include "app/calibration/calibration.h"

#include <filesystem>
#include <string_view>
#include <system_error>

#include "app/calibration/calibration_fields.h"
#include "app/support/input_error.h"

namespace facet {
namespace {

constexpr double kMaxTimeShiftS = 1.0;
constexpr const char* kChainName = "camchain.yaml";  // in a log's root
constexpr const char* kImuName = "imu.yaml";

Duration read_time_shift(const YamlNode& camera) {
    if (!camera.has("timeshift_cam_imu")) {
        return {};
    }
    const YamlNode field = camera.at("timeshift_cam_imu");
    const double shift_s = field.number();
    if (shift_s < -kMaxTimeShiftS || shift_s > kMaxTimeShiftS) {
        field.fail("more than 1 s: cameras and IMU are not on one clock");
    }
    return Duration::from_seconds(shift_s);
}

}  // namespace

Calibration load_euroc_calibration(const std::string& root) {
    const YamlNode left = load_yaml(root + "/cam0/sensor.yaml");
    const bool has_right = std::filesystem::exists(root + "/cam1");
    const YamlNode right = load_yaml(root + (has_right ? "/cam1/sensor.yaml" : "/cam0/sensor.yaml"));
    const YamlNode imu = load_yaml(root + "/imu0/sensor.yaml");
    const Se3 T_I_B = read_transform(imu.at("T_BS")).inverse();

    Calibration calibration;
    calibration.rig = {.left = read_camera(left, "distortion_coefficients"),
                       .right = read_camera(right, "distortion_coefficients"),
                       .T_B_C0 = T_I_B * read_transform(left.at("T_BS")),
                       .T_B_C1 = T_I_B * read_transform(right.at("T_BS"))};
    if (has_right) {
        check_baseline(calibration.rig, right.at("T_BS"));
    } else {
        calibration.rig = StereoRig::monocular(calibration.rig.left, calibration.rig.T_B_C0);
    }
    calibration.noise = read_imu_noise(imu, "rate_hz");
    calibration.camera_time_shift = read_time_shift(left);
    calibration.sigmas = read_stated_sigmas(left, right);
    calibration.source = "sensor.yaml";
    for (const char* place : {"cam0/sensor.yaml", "cam1/sensor.yaml", "imu0/sensor.yaml"}) {
        if (has_right || std::string_view(place) != "cam1/sensor.yaml") {
            calibration.files.push_back({root + "/" + place, place});
        }
    }
    return calibration;
}

void load_kalibr_cameras(const std::string& camchain_path, Calibration& calibration) {
    const YamlNode chain = load_yaml(camchain_path);
    const YamlNode left = chain.at("cam0");
    const bool has_right = chain.has("cam1");
    for (const auto& entry : chain.raw()) {
        const std::string& name = entry.first.Scalar();  // empty if the key is no text
        if (!has_right && name != "cam0" && name.starts_with("cam")) {
            chain.at(name).fail("is there without cam1: call the second camera cam1, or leave cam0 alone");
        }
    }
    const YamlNode right = chain.at(has_right ? "cam1" : "cam0");
    StereoRig rig;
    rig.left = read_camera(left, "distortion_coeffs");
    rig.right = read_camera(right, "distortion_coeffs");
    const Se3 T_C0_B = read_transform(left.at("T_cam_imu"));
    rig.T_B_C0 = T_C0_B.inverse();
    const bool from_imu = right.has("T_cam_imu") || !right.has("T_cn_cnm1");  // neither: complain of T_cam_imu
    const YamlNode extrinsics = right.at(from_imu ? "T_cam_imu" : "T_cn_cnm1");
    const Se3 T_C1_other = read_transform(extrinsics);
    rig.T_B_C1 = from_imu ? T_C1_other.inverse() : (T_C1_other * T_C0_B).inverse();
    if (has_right) {
        check_baseline(rig, extrinsics);
    }
    calibration.rig = has_right ? rig : StereoRig::monocular(rig.left, rig.T_B_C0);
    calibration.camera_time_shift = read_time_shift(left);
    calibration.sigmas = read_stated_sigmas(left, right);
    calibration.source = "camchain";
    calibration.files.clear();
}

void load_kalibr_imu(const std::string& imu_path, Calibration& calibration) {
    const YamlNode file = load_yaml(imu_path);
    calibration.noise = read_imu_noise(file.has("imu0") ? file.at("imu0") : file, "update_rate");
    calibration.files.clear();
}

Calibration load_calibration(const std::string& root, const std::string& cameras, const std::string& imu) {
    namespace fs = std::filesystem;
    if (fs::is_regular_file(cameras) && !imu.empty()) {
        return load_kalibr_calibration(cameras, imu);
    }
    Calibration calibration;
    if (fs::is_directory(cameras)) {
        calibration = load_euroc_calibration(fs::is_directory(cameras + "/mav0") ? cameras + "/mav0" : cameras);
        calibration.source = cameras;
    } else {
        const bool is_kalibr = !fs::exists(root + "/cam0/sensor.yaml") && fs::exists(root + "/" + kChainName);
        calibration = is_kalibr ? load_kalibr_calibration(root + "/" + kChainName, root + "/" + kImuName)
                                : load_euroc_calibration(root);
        if (!cameras.empty()) {
            load_kalibr_cameras(cameras, calibration);
        }
    }
    if (!imu.empty()) {
        load_kalibr_imu(imu, calibration);
    }
    return calibration;
}

void keep_calibration(const Calibration& calibration, const std::string& root) {
    for (const CalibrationFile& file : calibration.files) {
        std::error_code error;
        std::filesystem::copy_file(file.path, root + "/" + file.place, error);
        if (error) {
            throw InputError(root + "/" + file.place + ": cannot be copied from " + file.path + ": " + error.message());
        }
    }
}

Calibration load_kalibr_calibration(const std::string& camchain_path, const std::string& imu_path) {
    Calibration calibration;
    load_kalibr_cameras(camchain_path, calibration);
    load_kalibr_imu(imu_path, calibration);
    calibration.files = {{camchain_path, kChainName}, {imu_path, kImuName}};
    return calibration;
}

}  // namespace facet
