// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/sim/asl_writer.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <iterator>

namespace facet::sim {
namespace {

using Text = fmt::memory_buffer;

Status save(const std::string& path, const Text& text, std::string& failed) {
    std::ofstream file(path, std::ios::binary);
    file.write(text.data(), static_cast<std::streamsize>(text.size()));
    file.close();
    if (!file) {
        failed = path;
        return Status::kIo;
    }
    return Status::kOk;
}

void put_matrix(Text& text, const Eigen::Matrix4d& t) {
    auto out = std::back_inserter(text);
    fmt::format_to(out, "T_BS:\n  cols: 4\n  rows: 4\n  data: [");
    for (int row = 0; row < 4; ++row) {
        for (int column = 0; column < 4; ++column) {
            fmt::format_to(out, "{:.12g}", t(row, column));
            fmt::format_to(out, "{}", column < 3 ? ", " : (row < 3 ? ",\n         " : "]\n"));
        }
    }
}

Text camera_yaml(int index, const CameraIntrinsics& k, const Eigen::Matrix4d& T_B_C, double rate_hz) {
    Text text;
    auto out = std::back_inserter(text);
    fmt::format_to(out, "%YAML:1.0\n# General sensor definitions.\nsensor_type: camera\ncomment: simulated cam{}\n\n",
                   index);
    fmt::format_to(out, "# Sensor extrinsics wrt. the body-frame.\n");
    put_matrix(text, T_B_C);
    fmt::format_to(out,
                   "\n# Camera specific definitions.\nrate_hz: {:.12g}\nresolution: [{}, {}]\ncamera_model: pinhole\n",
                   rate_hz, k.width, k.height);
    fmt::format_to(out, "intrinsics: [{:.12g}, {:.12g}, {:.12g}, {:.12g}] #fu, fv, cu, cv\n", k.fx, k.fy, k.cx, k.cy);
    fmt::format_to(out, "distortion_model: {}\n",
                   k.distortion == Distortion::kEquidistant ? "equidistant" : "radial-tangential");
    fmt::format_to(out, "distortion_coefficients: [{:.12g}, {:.12g}, {:.12g}, {:.12g}]\n", k.coeffs[0], k.coeffs[1],
                   k.coeffs[2], k.coeffs[3]);
    return text;
}

Text imu_yaml(const ImuNoise& noise) {
    Text text;
    auto out = std::back_inserter(text);
    fmt::format_to(
        out, "%YAML:1.0\n#Default imu sensor yaml file\nsensor_type: imu\ncomment: simulated, ADIS16448 noise\n\n");
    fmt::format_to(out, "# Sensor extrinsics wrt. the body-frame.\n");
    put_matrix(text, Eigen::Matrix4d::Identity());
    fmt::format_to(out, "rate_hz: {:.12g}\n\n# inertial sensor noise model parameters (static)\n", noise.rate_hz);
    fmt::format_to(out, "gyroscope_noise_density: {:.12g}     # [ rad / s / sqrt(Hz) ]\n",
                   noise.gyro_noise_rad_per_s_per_sqrt_hz);
    fmt::format_to(out, "gyroscope_random_walk: {:.12g}       # [ rad / s^2 / sqrt(Hz) ]\n",
                   noise.gyro_walk_rad_per_s2_per_sqrt_hz);
    fmt::format_to(out, "accelerometer_noise_density: {:.12g}  # [ m / s^2 / sqrt(Hz) ]\n",
                   noise.accel_noise_m_per_s2_per_sqrt_hz);
    fmt::format_to(out, "accelerometer_random_walk: {:.12g}    # [ m / s^3 / sqrt(Hz) ]\n",
                   noise.accel_walk_m_per_s3_per_sqrt_hz);
    return text;
}

Text groundtruth_yaml() {
    Text text;
    fmt::format_to(std::back_inserter(text),
                   "%YAML:1.0\nsensor_type: visual-inertial\ncomment: the spline the images and the IMU come from\n");
    put_matrix(text, Eigen::Matrix4d::Identity());
    return text;
}

Text camera_csv(std::span<const Timestamp> stamps) {
    Text text;
    auto out = std::back_inserter(text);
    fmt::format_to(out, "#timestamp [ns],filename\n");
    for (const Timestamp stamp : stamps) {
        fmt::format_to(out, "{0},{0}.png\n", stamp.ns);
    }
    return text;
}

Text imu_csv(std::span<const ImuRecord> imu) {
    Text text;
    auto out = std::back_inserter(text);
    fmt::format_to(out,
                   "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m "
                   "s^-2],a_RS_S_y [m s^-2],"
                   "a_RS_S_z [m s^-2]\n");
    for (const ImuRecord& r : imu) {
        const Eigen::Vector3d& w = r.sample.w_B;
        const Eigen::Vector3d& a = r.sample.a_B;
        fmt::format_to(out, "{},{:.12g},{:.12g},{:.12g},{:.12g},{:.12g},{:.12g}\n", r.sample.stamp.ns, w.x(), w.y(),
                       w.z(), a.x(), a.y(), a.z());
    }
    return text;
}

Text groundtruth_csv(std::span<const ImuRecord> imu) {
    Text text;
    auto out = std::back_inserter(text);
    fmt::format_to(
        out,
        "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z [], v_RS_R_x [m "
        "s^-1], "
        "v_RS_R_y [m s^-1], v_RS_R_z [m s^-1], b_w_RS_S_x [rad s^-1], b_w_RS_S_y [rad s^-1], b_w_RS_S_z [rad s^-1], "
        "b_a_RS_S_x [m s^-2], b_a_RS_S_y [m s^-2], b_a_RS_S_z [m s^-2]\n");
    for (const ImuRecord& r : imu) {
        const Eigen::Vector3d& p = r.state.T_W_B.p;
        const Eigen::Quaterniond& q = r.state.T_W_B.q;
        const Eigen::Vector3d& v = r.state.v_W;
        fmt::format_to(out, "{},{:.9f},{:.9f},{:.9f},{:.10f},{:.10f},{:.10f},{:.10f},{:.9f},{:.9f},{:.9f}",
                       r.sample.stamp.ns, p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z(), v.x(), v.y(), v.z());
        for (const Eigen::Vector3d& b : {r.bias.gyro, r.bias.accel}) {
            fmt::format_to(out, ",{:.8f},{:.8f},{:.8f}", b.x(), b.y(), b.z());
        }
        fmt::format_to(out, "\n");
    }
    return text;
}

}  // namespace

std::string asl_image_path(const std::string& out, int camera, Timestamp stamp) {
    return fmt::format("{}/mav0/cam{}/data/{}.png", out, camera, stamp.ns);
}

Status write_camera_yaml(const std::string& path, int camera, const AslContent& content, std::string& failed) {
    const CameraModel& model = camera == 0 ? content.rig->left : content.rig->right;
    return save(path,
                camera_yaml(camera, model.intrinsics(), content.T_B_C[static_cast<std::size_t>(camera)],
                            content.camera_rate_hz),
                failed);
}

Status write_asl(const std::string& out, const AslContent& content, std::string& failed) {
    const std::string mav0 = out + "/mav0";
    for (const char* folder : {"/cam0/data", "/cam1/data", "/imu0", "/state_groundtruth_estimate0"}) {
        std::error_code error;
        std::filesystem::create_directories(mav0 + folder, error);
        if (error) {
            failed = mav0 + folder;
            return Status::kIo;
        }
    }
    Text body;
    fmt::format_to(std::back_inserter(body), "%YAML:1.0\ncomment: simulated, EuRoC calibration\n");
    FACET_TRY(save(mav0 + "/body.yaml", body, failed));
    for (int camera = 0; camera < 2; ++camera) {
        const std::string folder = fmt::format("{}/cam{}", mav0, camera);
        FACET_TRY(write_camera_yaml(folder + "/sensor.yaml", camera, content, failed));
        FACET_TRY(save(folder + "/data.csv", camera_csv(content.image_stamps), failed));
    }
    FACET_TRY(save(mav0 + "/imu0/sensor.yaml", imu_yaml(content.imu_noise), failed));
    FACET_TRY(save(mav0 + "/imu0/data.csv", imu_csv(content.imu), failed));
    FACET_TRY(save(mav0 + "/state_groundtruth_estimate0/sensor.yaml", groundtruth_yaml(), failed));
    return save(mav0 + "/state_groundtruth_estimate0/data.csv", groundtruth_csv(content.imu), failed);
}

}  // namespace facet::sim
