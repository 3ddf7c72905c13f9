// SPDX-License-Identifier: BSD-2-Clause
#include "app/calibration/calibration_kind.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <vector>

namespace facet {
namespace {

/// A kind, the keys of which one tells it from those behind it, and what a file of it is.
struct KindMark {
    CalibrationKind kind;
    std::array<const char*, 3> any_of;
    const char* text;
};

constexpr std::array kMarks{
    KindMark{CalibrationKind::kVins, {"cam0_calib", "body_T_cam0", "extrinsicRotation"}, "a configuration of VINS"},
    KindMark{CalibrationKind::kCameraChain, {"cam0", "cam1", nullptr}, "a camera chain of Kalibr or OpenVINS"},
    KindMark{CalibrationKind::kBasalt, {"value0", nullptr, nullptr}, "a calibration of Basalt"},
    KindMark{CalibrationKind::kOrbSlam, {"Camera.type", "Camera1.fx", "Camera.fx"}, "a settings file of ORB-SLAM"},
    KindMark{CalibrationKind::kCamodocal,
             {"model_type", "projection_parameters", nullptr},
             "the lens of one camera as camodocal writes it"},
    KindMark{CalibrationKind::kRealSenseImu, {"imus", nullptr, nullptr}, "the calibration of a RealSense's IMU"},
    KindMark{CalibrationKind::kRealSensePreset,
             {"viewer", "schema version", "param-disparityshift"},
             "a preset of realsense-viewer"},
    KindMark{CalibrationKind::kOkvis, {"cameras", "camera_parameters", nullptr}, "a configuration of OKVIS"},
    KindMark{CalibrationKind::kCameraInfo,
             {"camera_matrix", "image_width", "projection_matrix"},
             "the lens of one camera as ROS's camera_info has it"},
    KindMark{CalibrationKind::kOpenCvStereo, {"M1", "K1", "cameraMatrix1"}, "a stereo calibration of OpenCV"},
    KindMark{CalibrationKind::kDepthAi, {"cameraData", "imuExtrinsics", nullptr}, "the calibration of an OAK camera"},
    KindMark{CalibrationKind::kImu,
             {"imu0", "gyroscope_noise_density", "accelerometer_noise_density"},
             "the calibration of an IMU"},
    KindMark{CalibrationKind::kEurocCamera, {"T_BS", "intrinsics", "camera_model"}, "a sensor.yaml of one camera"},
};

const char* text_of(CalibrationKind kind) {
    const auto* const mark = std::ranges::find(kMarks, kind, &KindMark::kind);
    return mark == kMarks.end() ? "no calibration of a known kind" : mark->text;
}

[[noreturn]] void refuse_unknown(const YamlNode& root) {
    constexpr std::size_t kMostKeys = 5;
    std::vector<std::string> keys;
    for (const auto& entry : root.raw()) {
        if (entry.first.IsScalar() && keys.size() < kMostKeys) {
            keys.push_back(entry.first.Scalar().substr(0, 40));
        }
    }
    root.fail(
        fmt::format("is not a calibration of a known kind; it has {}{}; known are those of Kalibr, OpenVINS, EuRoC, "
                    "Kimera, Basalt, ORB-SLAM3, OKVIS2, VINS-Fusion, OAK and RealSense (rs-enumerate-devices -c)",
                    keys.empty() ? "no key" : fmt::format("{}", fmt::join(keys, ", ")),
                    root.raw().size() > keys.size() ? ", ..." : ""));
}

}  // namespace

CalibrationKind kind_of_calibration(const YamlNode& root) {
    const auto has_any = [&](const KindMark& mark) {
        return std::ranges::any_of(mark.any_of, [&](const char* key) { return key != nullptr && root.has(key); });
    };
    const auto* const mark = std::ranges::find_if(kMarks, has_any);
    return mark == kMarks.end() ? CalibrationKind::kUnknown : mark->kind;
}

void refuse_as_cameras(const YamlNode& root, CalibrationKind kind) {
    const std::string what = fmt::format("is {}: ", text_of(kind));
    constexpr const char* kNoMount =
        "it does not say where the camera sits against the IMU; write a camera chain with T_cam_imu for each camera "
        "(docs/use.md, Calibration), or let Kalibr's kalibr_calibrate_imu_camera make one";
    switch (kind) {
        case CalibrationKind::kImu: root.fail(what + "give it as --imu-calibration, and the cameras' as --calibration");
        case CalibrationKind::kEurocCamera:
            root.fail(what + "give the folder that holds cam0, cam1 and imu0, or Kimera's files");
        case CalibrationKind::kCamodocal:
            root.fail(what + "give the configuration of VINS that names it, which has body_T_cam0");
        case CalibrationKind::kRealSenseImu:
        case CalibrationKind::kRealSensePreset:
            root.fail(what + "it has no cameras; rs-enumerate-devices -c > FILE writes what does");
        case CalibrationKind::kCameraInfo:
        case CalibrationKind::kOpenCvStereo: root.fail(what + kNoMount);
        case CalibrationKind::kDepthAi:
        case CalibrationKind::kBasalt:
        case CalibrationKind::kOrbSlam:
        case CalibrationKind::kVins:
        case CalibrationKind::kOkvis:
            root.fail(what + "here it must be Kalibr's; facet calibration FILE --to kalibr makes one of it");
        default: refuse_unknown(root);
    }
}

void refuse_as_imu(const YamlNode& root, CalibrationKind kind) {
    if (kind == CalibrationKind::kUnknown) {
        root.fail(
            "is not a calibration of an IMU: gyroscope_noise_density and its like are missing (Kalibr's imu.yaml, or "
            "EuRoC's imu0/sensor.yaml)");
    }
    root.fail(
        fmt::format("is {}: give it as --calibration, and Kalibr's imu.yaml as --imu-calibration", text_of(kind)));
}

}  // namespace facet
