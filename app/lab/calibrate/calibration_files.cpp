// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/calibrate/calibration_files.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "app/calibration/calibration_writer.h"
#include "app/support/text_file.h"
#include "platform/base/angle.h"

namespace facet {
namespace {

using Json = nlohmann::ordered_json;

/// One camera of a calibration, with the sigmas of its parameters.
struct RefinedCamera {
    const CameraIntrinsics& k;
    Se3 T_B_C;
    Eigen::Matrix<double, kBatchLensDim, 1> lens_sigma;  ///< focal lengths in pixels
    Eigen::Matrix<double, kBatchMountDim, 1> mount_sigma;
};

RefinedCamera camera_of(const RefinedCalibration& c, std::size_t camera) {
    const StereoRig& rig = c.refined.rig;
    const CameraIntrinsics& k = (camera == 0 ? rig.left : rig.right).intrinsics();
    RefinedCamera out{k, camera == 0 ? rig.T_B_C0 : rig.T_B_C1, c.sigma.segment<kBatchLensDim>(kBatchLens[camera]),
                      c.sigma.segment<kBatchMountDim>(kBatchMount[camera])};
    out.lens_sigma(0) *= k.fx;
    out.lens_sigma(1) *= k.fy;
    return out;
}

std::string row_of(const Eigen::Matrix4d& t, int row) {
    return fmt::format("{:.12g}, {:.12g}, {:.12g}, {:.12g}", t(row, 0), t(row, 1), t(row, 2), t(row, 3));
}

template <class Vector>
std::string list_of(const Vector& v, const char* format = "{:.3g}") {
    std::string text = "[";
    for (Eigen::Index i = 0; i < v.size(); ++i) {
        text += (i > 0 ? ", " : "") + fmt::format(fmt::runtime(format), v(i));
    }
    return text + "]";
}

/// How EuRoC's and Kalibr's files differ in what they say of a lens.
struct LensStyle {
    const char* indent;
    const char* coefficients;
    const char* radial_tangential;
};
constexpr LensStyle kEuroc{"", "distortion_coefficients", "radial-tangential"};
constexpr LensStyle kKalibr{"  ", "distortion_coeffs", "radtan"};

void write_lens(TextFile& file, const RefinedCamera& c, const LensStyle& style) {
    const CameraIntrinsics& k = c.k;
    const char* indent = style.indent;
    const LensText lens = describe_lens(k);
    const bool is_radtan = std::string_view(lens.distortion) == "radtan";
    file.print("{}camera_model: {}\n", indent, lens.model);
    file.print("{}resolution: [{}, {}]\n", indent, k.width, k.height);
    file.print("{}intrinsics: {}\n", indent, list_text(lens.intrinsics));
    file.print("{}intrinsics_sigma: {}  # px\n", indent, list_of(c.lens_sigma.head<4>()));
    file.print("{}distortion_model: {}\n", indent, is_radtan ? style.radial_tangential : lens.distortion);
    file.print("{}{}: {}\n", indent, style.coefficients, list_text(lens.coefficients));
    file.print("{}distortion_sigma: {}\n", indent, list_of(c.lens_sigma.tail<4>()));
    file.print("{}rotation_sigma_deg: {}  # about the camera's axes\n", indent,
               list_of(c.mount_sigma.head<3>() / kRadPerDeg));
    file.print("{}position_sigma_m: {}  # along the body's axes\n", indent, list_of(c.mount_sigma.tail<3>()));
}

void write_body_pose(TextFile& file, const Eigen::Matrix4d& t) {
    file.print("T_BS:\n  cols: 4\n  rows: 4\n  data: [{},\n         {},\n         {},\n         {}]\n", row_of(t, 0),
               row_of(t, 1), row_of(t, 2), row_of(t, 3));
}

void write_euroc_camera(const RefinedCalibration& c, std::size_t camera, const std::string& folder) {
    const std::string cam = fmt::format("{}/cam{}", folder, camera);
    make_folder(cam);
    TextFile file(cam + "/sensor.yaml");
    const RefinedCamera refined = camera_of(c, camera);
    file.print("%YAML:1.0\n# Refined from a flight; the body frame is the IMU.\nsensor_type: camera\n");
    write_body_pose(file, refined.T_B_C.matrix());
    write_lens(file, refined, kEuroc);
    file.print("timeshift_cam_imu: {:.9g}  # s, t_imu = t_cam + shift\ntimeshift_sigma: {:.3g}\n",
               c.refined.time_shift_s, c.sigma(kBatchTime));
    file.close();
}

void write_noise(TextFile& file, const ImuNoise& noise, const char* rate_key) {
    file.print("gyroscope_noise_density: {:.9g}      # rad/s/sqrt(Hz)\n", noise.gyro_noise_rad_per_s_per_sqrt_hz);
    file.print("gyroscope_random_walk: {:.9g}        # rad/s^2/sqrt(Hz)\n", noise.gyro_walk_rad_per_s2_per_sqrt_hz);
    file.print("accelerometer_noise_density: {:.9g}  # m/s^2/sqrt(Hz)\n", noise.accel_noise_m_per_s2_per_sqrt_hz);
    file.print("accelerometer_random_walk: {:.9g}    # m/s^3/sqrt(Hz)\n", noise.accel_walk_m_per_s3_per_sqrt_hz);
    file.print("{}: {:.9g}\n", rate_key, noise.rate_hz);
}

void write_imu(const RefinedCalibration& c, const std::string& folder) {
    make_folder(folder + "/imu0");
    TextFile euroc(folder + "/imu0/sensor.yaml");
    euroc.print("%YAML:1.0\n# As given.\nsensor_type: imu\n");
    write_body_pose(euroc, Eigen::Matrix4d::Identity());
    write_noise(euroc, c.noise, "rate_hz");
    write_imu_model(euroc, c.imu_model, "");
    euroc.close();
    TextFile kalibr(folder + "/imu.yaml");
    kalibr.print("# As given.\n");
    write_noise(kalibr, c.noise, "update_rate");
    write_imu_model(kalibr, c.imu_model, "");
    kalibr.close();
}

void write_matrix_rows(TextFile& file, const char* key, const Eigen::Matrix4d& t) {
    file.print("  {}:\n", key);
    for (int row = 0; row < 4; ++row) {
        file.print("    - [{}]\n", row_of(t, row));
    }
}

void write_camchain(const RefinedCalibration& c, const std::string& path) {
    TextFile file(path);
    file.print("# Refined from a flight.\n");
    for (std::size_t camera = 0; camera < 2; ++camera) {
        const RefinedCamera refined = camera_of(c, camera);
        file.print("cam{}:\n", camera);
        write_matrix_rows(file, "T_cam_imu", refined.T_B_C.inverse().matrix());
        if (camera == 1) {
            write_matrix_rows(file, "T_cn_cnm1", c.refined.rig.T_C1_C0().matrix());
        }
        write_lens(file, refined, kKalibr);
        file.print("  timeshift_cam_imu: {:.9g}\n  timeshift_sigma: {:.3g}\n", c.refined.time_shift_s,
                   c.sigma(kBatchTime));
    }
    file.close();
}

/// Root mean square of the residuals of a camera and their means, which should be zero.
Json fit(const std::vector<SightingResidual>& residuals, int camera) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    double squares = 0.0;
    std::size_t count = 0;
    for (const SightingResidual& r : residuals) {
        if (r.camera == camera) {
            sum += r.error_px;
            squares += r.error_px.squaredNorm();
            ++count;
        }
    }
    const double n = std::max<double>(1.0, static_cast<double>(count));
    return {{"sightings", count},
            {"rms_px", std::sqrt(squares / (2.0 * n))},
            {"mean_px", Json::array({sum.x() / n, sum.y() / n})}};
}

}  // namespace

void write_calibration(const RefinedCalibration& calibration, const std::string& folder) {
    make_folder(folder);
    write_euroc_camera(calibration, 0, folder);
    write_euroc_camera(calibration, 1, folder);
    write_imu(calibration, folder);
    write_camchain(calibration, folder + "/camchain-imucam.yaml");
}

void write_calibration_json(const CalibrationAccount& account, const BatchResult& result, const std::string& folder) {
    Json parameters = Json::array();
    for (const RigParameter& p : account.parameters) {
        Json row{{"name", p.name},
                 {"unit", p.unit},
                 {"given", p.given},
                 {"refined", p.refined},
                 {"sigma", p.sigma},
                 {"prior_sigma", p.prior_sigma},
                 {"verdict", to_string(p.verdict)}};
        if (p.verdict != ParameterVerdict::kFound) {
            row["advice"] = p.advice;
        }
        parameters.push_back(row);
    }
    const auto both = [](const std::vector<SightingResidual>& residuals) {
        return Json{{"cam0", fit(residuals, 0)}, {"cam1", fit(residuals, 1)}};
    };
    const Json root{{"dataset", account.dataset},
                    {"given", account.source},
                    {"duration_s", account.duration_s},
                    {"keyframes", result.keyframes},
                    {"points", result.points},
                    {"sightings", result.sightings},
                    {"pixel_sigma_px", result.pixel_sigma},
                    {"residuals", {{"before", both(result.before)}, {"after", both(result.after)}}},
                    {"parameters", parameters}};
    TextFile file(folder + "/calibration.json");
    file.write(root.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
    file.close();
}

}  // namespace facet
