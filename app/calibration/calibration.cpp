// SPDX-License-Identifier: BSD-2-Clause
#include "app/calibration/calibration.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <system_error>

#include "app/calibration/calibration_fields.h"
#include "app/calibration/calibration_kind.h"
#include "app/calibration/depthai_cameras.h"
#include "app/calibration/imu_fields.h"
#include "app/calibration/other_cameras.h"
#include "app/calibration/realsense_cameras.h"
#include "app/support/input_error.h"

namespace facet {
namespace {

namespace fs = std::filesystem;

constexpr const char* kChainName = "camchain.yaml";  // in a log's root
constexpr const char* kImuName = "imu.yaml";

/// The three files of a rig whose cameras have a file each.
struct SensorFiles {
    std::string left;
    std::string right;
    std::string imu;
};
SensorFiles euroc_files(const std::string& root) {
    return {root + "/cam0/sensor.yaml", root + "/cam1/sensor.yaml", root + "/imu0/sensor.yaml"};
}
SensorFiles kimera_files(const std::string& folder) {
    return {folder + "/LeftCameraParams.yaml", folder + "/RightCameraParams.yaml", folder + "/ImuParams.yaml"};
}

/// What a camera's entry holds and nothing is made of.
void remark_camera(const YamlNode& camera, std::vector<std::string>& remarks) {
    remark_unused(camera,
                  {"T_BS",
                   "T_cam_imu",
                   "T_imu_cam",
                   "T_cn_cnm1",
                   "T_cam_cnm1",
                   "cam_overlaps",
                   "camera_id",
                   "camera_model",
                   "comment",
                   "distortion_coefficients",
                   "distortion_coeffs",
                   "distortion_model",
                   "distortion_sigma",
                   "intrinsics",
                   "intrinsics_sigma",
                   "position_sigma_m",
                   "rate_hz",
                   "resolution",
                   "rostopic",
                   "rotation_sigma_deg",
                   "sensor_type",
                   "timeshift_cam_imu",
                   "timeshift_sigma"},
                  remarks);
}

/// What an IMU's file holds and nothing is made of.
void remark_imu(const YamlNode& imu, std::vector<std::string>& remarks) {
    remark_unused(imu,
                  {"T_BS",
                   "T_i_b",
                   "Ta",
                   "Tg",
                   "Tw",
                   "R_IMUtoACC",
                   "R_IMUtoGYRO",
                   "accelerometer_noise_density",
                   "accelerometer_random_walk",
                   "accelerometers",
                   "comment",
                   "gyroscope_noise_density",
                   "gyroscope_random_walk",
                   "gyroscopes",
                   "model",
                   "rate_hz",
                   "rostopic",
                   "sensor_type",
                   "time_offset",
                   "update_rate"},
                  remarks);
    if (imu.has("accelerometers")) {
        remark_unused(imu.at("accelerometers"), {"M"}, remarks);
    }
    if (imu.has("time_offset") && imu.at("time_offset").number() != 0.0) {
        remarks.push_back(fmt::format("{}:{}: time_offset: is not used", imu.file(), imu.at("time_offset").line()));
    }
}

/// Noise and model of an IMU, whoever wrote them.
void read_imu(const YamlNode& imu, Calibration& calibration) {
    calibration.noise = read_imu_noise(imu, imu.has("rate_hz") ? "rate_hz" : "update_rate");
    calibration.imu_model = read_imu_model(imu);
    if (imu.has("T_i_b") && !read_transform(imu.at("T_i_b")).matrix().isIdentity(1e-6)) {
        imu.at("T_i_b").fail("is not the identity: the cameras' transforms are those of another IMU");
    }
    remark_imu(imu, calibration.remarks);
}

YamlNode imu_node(const std::string& path) {
    if (is_realsense_listing(path)) {
        throw InputError(path +
                         ": is the calibration of a RealSense camera: give it as --calibration; it does not say how "
                         "noisy the IMU is, which Kalibr's imu.yaml does");
    }
    const YamlNode file = load_yaml(path);
    const CalibrationKind kind = kind_of_calibration(file);
    // EuRoC's sensor.yaml of an IMU, whose noise is missing, is told so.
    if (kind != CalibrationKind::kImu && !(kind == CalibrationKind::kEurocCamera && !file.has("intrinsics"))) {
        refuse_as_imu(file, kind);
    }
    return file.has("imu0") ? file.at("imu0") : file;
}

/// Cameras that have a file each. @param T_I_B  body to IMU
void read_sensor_cameras(const SensorFiles& files, const Se3& T_I_B, Calibration& calibration) {
    const YamlNode left = load_yaml(files.left);
    const bool has_right = files.right != files.left && fs::exists(fs::path(files.right).parent_path());
    const YamlNode right = load_yaml(has_right ? files.right : files.left);
    calibration.rig = {.left = read_camera(left, "distortion_coefficients"),
                       .right = read_camera(right, "distortion_coefficients"),
                       .T_B_C0 = T_I_B * read_transform(left.at("T_BS")),
                       .T_B_C1 = T_I_B * read_transform(right.at("T_BS"))};
    if (has_right) {
        check_baseline(calibration.rig, right.at("T_BS"));
    } else {
        calibration.rig = StereoRig::monocular(calibration.rig.left, calibration.rig.T_B_C0);
    }
    calibration.camera_time_shift = read_time_shift(left, "timeshift_cam_imu");
    calibration.sigmas = read_stated_sigmas(left, right, calibration.rig);
    remark_camera(left, calibration.remarks);
    if (has_right) {
        remark_camera(right, calibration.remarks);
    }
}

Calibration load_sensors(const SensorFiles& files) {
    static_cast<void>(load_yaml(files.left));  // whose absence is told before that of the IMU's file
    const YamlNode imu = load_yaml(files.imu);
    Calibration calibration;
    read_sensor_cameras(files, read_transform(imu.at("T_BS")).inverse(), calibration);
    read_imu(imu, calibration);
    calibration.source = "sensor.yaml";
    return calibration;
}

/// T_B_C of a camera of a chain, however it is written.
Se3 read_mount(const YamlNode& camera) {
    if (camera.has("T_imu_cam") && !camera.has("T_cam_imu")) {
        return read_transform(camera.at("T_imu_cam"));
    }
    if (!camera.has("T_cam_imu")) {
        camera.fail(
            "T_cam_imu: missing, or T_imu_cam: this camera chain does not say where the cameras sit against the IMU, "
            "which Kalibr's kalibr_calibrate_imu_camera finds");
    }
    return read_transform(camera.at("T_cam_imu")).inverse();
}

void read_chain(const YamlNode& chain, Calibration& calibration) {
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
    rig.T_B_C0 = read_mount(left);
    const bool from_left = !right.has("T_cam_imu") && !right.has("T_imu_cam") && right.has("T_cn_cnm1");
    rig.T_B_C1 =
        from_left ? (read_transform(right.at("T_cn_cnm1")) * rig.T_B_C0.inverse()).inverse() : read_mount(right);
    if (has_right) {
        check_baseline(
            rig, from_left ? right.at("T_cn_cnm1") : right.at(right.has("T_cam_imu") ? "T_cam_imu" : "T_imu_cam"));
    }
    calibration.rig = has_right ? rig : StereoRig::monocular(rig.left, rig.T_B_C0);
    calibration.camera_time_shift = read_time_shift(left, "timeshift_cam_imu");
    calibration.sigmas = read_stated_sigmas(left, right, rig);
    remark_unused(chain, {"cam0", "cam1"}, calibration.remarks);
    remark_camera(left, calibration.remarks);
    if (has_right) {
        constexpr Duration kAlike = Duration::from_seconds(1e-3);
        const Duration apart = read_time_shift(right, "timeshift_cam_imu") - calibration.camera_time_shift;
        if (right.has("timeshift_cam_imu") && (apart > kAlike || Duration{-apart.ns} > kAlike)) {
            calibration.remarks.push_back(fmt::format("{}:{}: cam1.timeshift_cam_imu: is not used, only that of cam0",
                                                      right.file(), right.at("timeshift_cam_imu").line()));
        }
        remark_camera(right, calibration.remarks);
    }
}

/// A file of cameras, whoever wrote it.
ImuFigures read_cameras(const std::string& path, const ImageExtent& images, Calibration& calibration) {
    calibration.files.clear();
    calibration.source = path;
    if (is_realsense_listing(path)) {
        read_realsense(path, images, calibration);
        return {};
    }
    const YamlNode root = load_yaml(path);
    const CalibrationKind kind = kind_of_calibration(root);
    switch (kind) {
        case CalibrationKind::kCameraChain:
            read_chain(root, calibration);
            calibration.source = "camchain";
            return {};
        case CalibrationKind::kBasalt: return read_basalt(root, calibration);
        case CalibrationKind::kOrbSlam: return read_orb_slam(root, calibration);
        case CalibrationKind::kVins: return read_vins(root, calibration);
        case CalibrationKind::kOkvis: return read_okvis(root, calibration);
        case CalibrationKind::kDepthAi: read_depthai(root, images, calibration); return {};
        default: refuse_as_cameras(root, kind);
    }
}

/// By the first stamps of a log's inertial samples; the default without them.
double measured_rate_hz(const std::string& root) {
    constexpr int kRows = 400;
    std::ifstream table(root + "/imu0/data.csv");
    std::vector<std::int64_t> stamps;
    for (std::string line; stamps.size() < kRows && std::getline(table, line);) {
        if (!line.empty() && line.front() >= '0' && line.front() <= '9') {
            stamps.push_back(std::strtoll(line.c_str(), nullptr, 10));
        }
    }
    std::vector<std::int64_t> steps;
    for (std::size_t i = 1; i < stamps.size(); ++i) {
        steps.push_back(stamps[i] - stamps[i - 1]);
    }
    constexpr double kNs = 1e9;
    if (steps.empty()) {
        return ImuNoise{}.rate_hz;
    }
    std::ranges::nth_element(steps, steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2));
    return std::clamp(kNs / static_cast<double>(std::max<std::int64_t>(1, steps[steps.size() / 2])), 20.0, 1e4);
}

/// The figures of the IMU that its cameras' file does not bring: from the log, or as usual.
void complete_imu(const std::string& root, const ImuFigures& brought, Calibration& calibration) {
    if (!brought.has_noise) {
        for (const std::string& path : {root + "/imu0/sensor.yaml", root + "/" + kImuName}) {
            if (fs::exists(path)) {
                read_imu(imu_node(path), calibration);
                return;
            }
        }
    }
    if (!brought.has_rate) {
        calibration.noise.rate_hz = measured_rate_hz(root);
    }
    if (!brought.has_noise) {
        calibration.remarks.push_back(fmt::format(
            "no file says how noisy the IMU is: {} rad/s/sqrt(Hz) and {} m/s^2/sqrt(Hz) at {:.4g} Hz are assumed; "
            "--imu-calibration imu.yaml states it",
            calibration.noise.gyro_noise_rad_per_s_per_sqrt_hz, calibration.noise.accel_noise_m_per_s2_per_sqrt_hz,
            calibration.noise.rate_hz));
    }
}

/// @param needs_imu  else its files may lack it
Calibration load_folder(const std::string& folder, bool needs_imu) {
    const std::string root = fs::is_directory(folder + "/mav0") ? folder + "/mav0" : folder;
    SensorFiles files = kimera_files(root);
    const bool is_kimera = !fs::exists(root + "/cam0") && fs::exists(files.left);
    if (!is_kimera) {
        files = euroc_files(root);
    } else if (!fs::exists(files.right)) {
        files.right = files.left;
    }
    if (!needs_imu && !fs::exists(files.imu)) {
        Calibration calibration;
        read_sensor_cameras(files, Se3{}, calibration);
        calibration.source = "sensor.yaml";
        return calibration;
    }
    return is_kimera ? load_sensors(files) : load_euroc_calibration(root);
}

/// What a log itself has.
Calibration load_own(const std::string& root, bool needs_imu) {
    if (fs::exists(root + "/cam0/sensor.yaml")) {
        return load_folder(root, needs_imu);
    }
    for (const char* name : {kChainName, "camchain-imucam.yaml"}) {
        if (fs::exists(root + "/" + name)) {
            Calibration calibration;
            load_kalibr_cameras(root + "/" + name, calibration);
            complete_imu(root, {.has_noise = !needs_imu, .has_rate = !needs_imu}, calibration);
            if (fs::exists(root + "/" + kImuName)) {
                calibration.files = {{root + "/" + name, kChainName}, {root + "/" + kImuName, kImuName}};
            }
            return calibration;
        }
    }
    throw InputError(
        root +
        ": has no calibration, neither cam0/sensor.yaml nor camchain.yaml: --calibration FILE names one "
        "(of Kalibr, OpenVINS, Basalt, ORB-SLAM3, OKVIS2, VINS-Fusion, RealSense, OAK; docs/use.md, Calibration)");
}

}  // namespace

Calibration load_euroc_calibration(const std::string& root) {
    Calibration calibration = load_sensors(euroc_files(root));
    for (const char* place : {"cam0/sensor.yaml", "cam1/sensor.yaml", "imu0/sensor.yaml"}) {
        if (calibration.rig.has_right || std::string_view(place) != "cam1/sensor.yaml") {
            calibration.files.push_back({root + "/" + place, place});
        }
    }
    const auto find_mask = [&](const std::string& place, std::string& path) {
        if (fs::exists(root + "/" + place)) {
            path = root + "/" + place;
            calibration.files.push_back({path, place});
        }
    };
    find_mask("cam0/mask.png", calibration.masks.left);
    if (calibration.rig.has_right) {
        find_mask("cam1/mask.png", calibration.masks.right);
    }
    return calibration;
}

void load_kalibr_cameras(const std::string& camchain_path, Calibration& calibration) {
    const YamlNode chain = load_yaml(camchain_path);
    if (!chain.has("cam0")) {
        if (const CalibrationKind kind = kind_of_calibration(chain); kind != CalibrationKind::kCameraChain) {
            refuse_as_cameras(chain, kind);
        }
    }
    read_chain(chain, calibration);
    calibration.source = "camchain";
    calibration.files.clear();
}

void load_kalibr_imu(const std::string& imu_path, Calibration& calibration) {
    read_imu(imu_node(imu_path), calibration);
    calibration.files.clear();
}

Calibration load_calibration(const std::string& root, const std::string& cameras, const std::string& imu,
                             const ImageExtent& images) {
    Calibration calibration;
    if (cameras.empty()) {
        calibration = load_own(root, imu.empty());
    } else if (fs::is_directory(cameras)) {
        calibration = load_folder(cameras, imu.empty());
        calibration.source = cameras;
    } else {
        const ImuFigures brought = read_cameras(cameras, images, calibration);
        if (imu.empty()) {
            complete_imu(root, brought, calibration);
        }
    }
    if (!imu.empty()) {
        load_kalibr_imu(imu, calibration);
        if (calibration.source == "camchain" && !cameras.empty()) {
            calibration.files = {{cameras, kChainName}, {imu, kImuName}};
        }
    }
    if (!calibration.rig.has_right && fs::is_directory(root + "/cam1")) {
        calibration.remarks.push_back("the calibration has one camera, the log two: its cam1 is not used");
    }
    return calibration;
}

Calibration load_kalibr_calibration(const std::string& camchain_path, const std::string& imu_path) {
    Calibration calibration;
    load_kalibr_cameras(camchain_path, calibration);
    load_kalibr_imu(imu_path, calibration);
    calibration.files = {{camchain_path, kChainName}, {imu_path, kImuName}};
    return calibration;
}

}  // namespace facet
