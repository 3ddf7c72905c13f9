// SPDX-License-Identifier: BSD-2-Clause
#include "app/calibration/calibration_writer.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <string_view>
#include <system_error>

#include "app/support/input_error.h"

namespace facet {
namespace {

/// Three or four rows, as Kalibr writes a matrix.
template <class Matrix>
void write_rows(TextFile& file, const std::string& indent, const char* key, const Matrix& m) {
    file.print("{}{}:\n", indent, key);
    for (Eigen::Index row = 0; row < m.rows(); ++row) {
        std::vector<double> values;
        for (Eigen::Index column = 0; column < m.cols(); ++column) {
            values.push_back(m(row, column));
        }
        file.print("{}- {}\n", indent, list_text(values));
    }
}

/// As OpenCV writes a matrix, and EuRoC.
template <class Matrix>
void write_data(TextFile& file, const char* key, const Matrix& m, const char* tag) {
    std::vector<double> values;
    for (Eigen::Index row = 0; row < m.rows(); ++row) {
        for (Eigen::Index column = 0; column < m.cols(); ++column) {
            values.push_back(m(row, column));
        }
    }
    file.print("{}:{}\n  rows: {}\n  cols: {}\n{}  data: {}\n", key, tag, m.rows(), m.cols(),
               *tag == '\0' ? "" : "  dt: d\n", list_text(values));
}

void write_noise(TextFile& file, const ImuNoise& noise, const std::string& indent, const char* rate_key) {
    file.print("{}gyroscope_noise_density: {:.9g}\n", indent, noise.gyro_noise_rad_per_s_per_sqrt_hz);
    file.print("{}gyroscope_random_walk: {:.9g}\n", indent, noise.gyro_walk_rad_per_s2_per_sqrt_hz);
    file.print("{}accelerometer_noise_density: {:.9g}\n", indent, noise.accel_noise_m_per_s2_per_sqrt_hz);
    file.print("{}accelerometer_random_walk: {:.9g}\n", indent, noise.accel_walk_m_per_s3_per_sqrt_hz);
    file.print("{}{}: {:.9g}\n", indent, rate_key, noise.rate_hz);
}

void write_lens(TextFile& file, const CameraIntrinsics& k, const std::string& indent, bool is_euroc) {
    const LensText lens = describe_lens(k);
    const bool is_radtan = std::string_view(lens.distortion) == "radtan";
    file.print("{}camera_model: {}\n", indent, lens.model);
    file.print("{}intrinsics: {}\n", indent, list_text(lens.intrinsics));
    file.print("{}distortion_model: {}\n", indent, is_euroc && is_radtan ? "radial-tangential" : lens.distortion);
    file.print("{}{}: {}\n", indent, is_euroc ? "distortion_coefficients" : "distortion_coeffs",
               list_text(lens.coefficients));
    file.print("{}resolution: [{}, {}]\n", indent, k.width, k.height);
}

void write_sensor_camera(const Calibration& calibration, int camera, const std::string& folder) {
    make_folder(folder);
    TextFile file(folder + "/sensor.yaml");
    file.print("%YAML:1.0\n# The body frame is the IMU.\nsensor_type: camera\n");
    const StereoRig& rig = calibration.rig;
    write_data(file, "T_BS", (camera == 0 ? rig.T_B_C0 : rig.T_B_C1).matrix(), "");
    write_lens(file, (camera == 0 ? rig.left : rig.right).intrinsics(), "", true);
    file.print("timeshift_cam_imu: {:.9f}\n", calibration.camera_time_shift.seconds());
    file.close();
}

/// @return OpenCV's coefficients, of a fisheye four
std::vector<double> opencv_coefficients(const CameraIntrinsics& k) {
    if (k.distortion != Distortion::kNone && k.distortion != Distortion::kRadialTangential &&
        k.distortion != Distortion::kRational && k.distortion != Distortion::kEquidistant) {
        throw InputError(fmt::format("--to opencv: OpenCV has no camera model '{}' with distortion '{}'",
                                     describe_lens(k).model, describe_lens(k).distortion));
    }
    return describe_lens(k).coefficients;
}

Eigen::Matrix3d camera_matrix(const CameraIntrinsics& k) {
    Eigen::Matrix3d m;
    m << k.fx, 0.0, k.cx, 0.0, k.fy, k.cy, 0.0, 0.0, 1.0;
    return m;
}

}  // namespace

LensText describe_lens(const CameraIntrinsics& k) {
    const std::vector<double> plane{k.fx, k.fy, k.cx, k.cy};
    const std::vector<double> four(k.coeffs.begin(), k.coeffs.end());
    const auto with = [&](std::initializer_list<double> own) {
        std::vector<double> all(own);
        all.insert(all.end(), plane.begin(), plane.end());
        return all;
    };
    switch (k.distortion) {
        case Distortion::kNone: return {"pinhole", plane, "none", four};
        case Distortion::kRadialTangential: return {"pinhole", plane, "radtan", four};
        case Distortion::kEquidistant: return {"pinhole", plane, "equidistant", four};
        case Distortion::kUnified: return {"omni", with({k.more[0]}), "radtan", four};
        case Distortion::kDoubleSphere: return {"ds", with({k.coeffs[0], k.coeffs[1]}), "none", {}};
        case Distortion::kEucm: return {"eucm", with({k.coeffs[0], k.coeffs[1]}), "none", {}};
        case Distortion::kFov: return {"pinhole", plane, "fov", {k.coeffs[0]}};
        case Distortion::kRational: break;
    }
    std::vector<double> eight = four;
    eight.insert(eight.end(), k.more.begin(), k.more.end());
    return {"pinhole", plane, "rational_polynomial", eight};
}

std::string list_text(const std::vector<double>& values) {
    std::string text = "[";
    for (std::size_t i = 0; i < values.size(); ++i) {
        text += fmt::format("{}{:.12g}", i > 0 ? ", " : "", values[i]);
    }
    return text + "]";
}

void write_imu_model(TextFile& file, const ImuModel& model, const std::string& indent) {
    if (model.is_ideal()) {
        return;
    }
    file.print("{}model: scale-misalignment\n{}accelerometers:\n", indent, indent);
    write_rows(file, indent + "  ", "M", model.M_a());
    file.print("{}gyroscopes:\n", indent);
    write_rows(file, indent + "  ", "M", model.M_w());
    write_rows(file, indent + "  ", "A", model.M_g());
    write_rows(file, indent + "  ", "C_gyro_i", Eigen::Matrix3d(Eigen::Matrix3d::Identity()));
}

void write_sensor_files(const Calibration& calibration, const std::string& folder) {
    write_sensor_camera(calibration, 0, folder + "/cam0");
    if (calibration.rig.has_right) {
        write_sensor_camera(calibration, 1, folder + "/cam1");
    }
    make_folder(folder + "/imu0");
    TextFile imu(folder + "/imu0/sensor.yaml");
    imu.print("%YAML:1.0\nsensor_type: imu\n");
    write_data(imu, "T_BS", Eigen::Matrix4d::Identity(), "");
    write_noise(imu, calibration.noise, "", "rate_hz");
    write_imu_model(imu, calibration.imu_model, "");
    imu.close();
}

void write_kalibr_files(const Calibration& calibration, const std::string& folder) {
    make_folder(folder);
    const StereoRig& rig = calibration.rig;
    TextFile chain(folder + "/camchain-imucam.yaml");
    for (int camera = 0; camera < (rig.has_right ? 2 : 1); ++camera) {
        chain.print("cam{}:\n", camera);
        write_rows(chain, "  ", "T_cam_imu", (camera == 0 ? rig.T_B_C0 : rig.T_B_C1).inverse().matrix());
        if (camera == 1) {
            write_rows(chain, "  ", "T_cn_cnm1", rig.T_C1_C0().matrix());
        }
        write_lens(chain, (camera == 0 ? rig.left : rig.right).intrinsics(), "  ", false);
        chain.print("  timeshift_cam_imu: {:.9f}\n", calibration.camera_time_shift.seconds());
    }
    chain.close();
    TextFile imu(folder + "/imu.yaml");
    imu.print("imu0:\n");
    write_noise(imu, calibration.noise, "  ", "update_rate");
    write_imu_model(imu, calibration.imu_model, "  ");
    imu.print("  rostopic: /imu0\n");
    imu.close();
}

void write_opencv_file(const Calibration& calibration, const std::string& folder) {
    const StereoRig& rig = calibration.rig;
    if (!rig.has_right) {
        throw InputError("--to opencv: one camera is not a stereo calibration");
    }
    const CameraIntrinsics& left = rig.left.intrinsics();
    const CameraIntrinsics& right = rig.right.intrinsics();
    const std::vector<double> d1 = opencv_coefficients(left);
    const std::vector<double> d2 = opencv_coefficients(right);
    const auto row = [](const std::vector<double>& d) {
        return Eigen::RowVectorXd(Eigen::Map<const Eigen::RowVectorXd>(d.data(), static_cast<Eigen::Index>(d.size())));
    };
    make_folder(folder);
    TextFile file(folder + "/stereo.yaml");
    constexpr const char* kTag = " !!opencv-matrix";
    file.print("%YAML:1.0\n---\nimage_width: {}\nimage_height: {}\n", left.width, left.height);
    file.print("distortion_model: {}\n", describe_lens(left).distortion);
    write_data(file, "M1", camera_matrix(left), kTag);
    write_data(file, "D1", row(d1), kTag);
    write_data(file, "M2", camera_matrix(right), kTag);
    write_data(file, "D2", row(d2), kTag);
    write_data(file, "R", rig.T_C1_C0().R(), kTag);
    write_data(file, "T", rig.T_C1_C0().p, kTag);
    file.close();
}

void keep_calibration(const Calibration& calibration, const std::string& root) {
    if (calibration.files.empty()) {
        write_sensor_files(calibration, root);
    }
    for (const CalibrationFile& file : calibration.files) {
        std::error_code error;
        std::filesystem::copy_file(file.path, root + "/" + file.place, error);
        if (error) {
            throw InputError(root + "/" + file.place + ": cannot be copied from " + file.path + ": " + error.message());
        }
    }
}

}  // namespace facet
