// SPDX-License-Identifier: BSD-2-Clause
#include "app/calibration/calibration.h"

#include <catch2/catch.hpp>
#include <filesystem>

#include "app/config/calibrated_config.h"
#include "tests/support/asl_folder.h"
#include "tests/support/input_error_text.h"
#include "tests/support/temp_dir.h"

namespace facet::calibration_test {
namespace {

using test::input_error_text;

/// First EuRoC camera and IMU files, as published (camera 1 shortened to what matters).
void write_euroc(const test::TempDir& dir) {
    for (int camera = 0; camera < 2; ++camera) {
        dir.write("cam" + std::to_string(camera) + "/sensor.yaml", test::asl_camera_yaml(camera));
    }
    dir.write("imu0/sensor.yaml", test::asl_imu_yaml());
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    REQUIRE(at != std::string::npos);
    return text.replace(at, from.size(), to);
}

TEST_CASE("EuRoC sensor.yaml gives rig and noise") {
    const test::TempDir dir;
    write_euroc(dir);
    // Both with and without OpenCV's first line.
    if (GENERATE(false, true)) {
        dir.write("cam0/sensor.yaml", replaced(test::asl_camera_yaml(0), "%YAML:1.0\n", ""));
    }
    const Calibration c = load_euroc_calibration(dir.path());
    CHECK(c.rig.left.intrinsics().width == 160);
    CHECK(c.rig.left.intrinsics().height == 120);
    CHECK(c.rig.left.intrinsics().fx == 150.0);
    CHECK(c.rig.left.intrinsics().cy == 59.5);
    CHECK(c.rig.left.intrinsics().distortion == Distortion::kRadialTangential);
    CHECK(c.rig.left.intrinsics().coeffs[0] == -0.1);
    CHECK(c.rig.baseline_m() == Approx(0.1));
    CHECK(c.rig.T_B_C1.p.x() == Approx(0.1));
    CHECK(c.noise.gyro_noise_rad_per_s_per_sqrt_hz == 1.7e-4);
    CHECK(c.noise.gyro_walk_rad_per_s2_per_sqrt_hz == 1.9e-5);
    CHECK(c.noise.accel_noise_m_per_s2_per_sqrt_hz == 2.0e-3);
    CHECK(c.noise.accel_walk_m_per_s3_per_sqrt_hz == 3.0e-3);
    CHECK(c.noise.rate_hz == 200.0);
    CHECK(c.camera_time_shift.ns == 0);
}

TEST_CASE("an IMU away from the body frame is composed in: the body is the IMU") {
    const test::TempDir dir;
    write_euroc(dir);
    // IMU turned by 90 degrees about z and 1 m along x: x_B = T_B_I x_I.
    dir.write("imu0/sensor.yaml", replaced(test::asl_imu_yaml(), "[1, 0, 0, 0,\n         0, 1, 0, 0,",
                                           "[0, -1, 0, 1,\n         1, 0, 0, 0,"));
    const Calibration c = load_euroc_calibration(dir.path());
    // C1 is at (0.1, 0, 0) in B, so at R^T ((0.1, 0, 0) - (1, 0, 0)) = (0, 0.9, 0) in the IMU frame.
    CHECK((c.rig.T_B_C1.p - Eigen::Vector3d(0.0, 0.9, 0.0)).norm() < 1e-12);
    CHECK((c.rig.T_B_C0 * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(0.0, 0.0, 0.0)).norm() < 1e-12);
}

TEST_CASE("a rotation rounded by its writer is projected onto SO(3)") {
    const test::TempDir dir;
    write_euroc(dir);
    dir.write("cam0/sensor.yaml", replaced(test::asl_camera_yaml(0), "[1, 0, 0, 0.0", "[1.0002, 0.0001, 0, 0.0"));
    const Eigen::Matrix3d r = load_euroc_calibration(dir.path()).rig.T_B_C0.R();
    CHECK((r.transpose() * r - Eigen::Matrix3d::Identity()).norm() < 1e-14);
    CHECK(r.determinant() == Approx(1.0));
}

/// One way to spoil a sensor.yaml, and the complaint.
struct BadField {
    const char* file;
    const char* from;
    const char* to;
    const char* complaint;  ///< after the path
};

const BadField kBadFields[] = {
    {"cam0", "T_BS:", "T_SB:", ":1: T_BS: missing"},
    {"cam0", "rows: 4", "rows: 3", ":3: T_BS: must be a 4x4 matrix"},
    {"cam0", "[1, 0, 0, 0.0", "[1, 0, 0", ":6: T_BS.data: must be a list of 16 numbers"},
    {"cam0", "[1, 0, 0, 0.0", "[1, 0, 0, left", ":6: T_BS.data.3: must be a number"},
    {"cam0", "[1, 0, 0, 0.0", "[1, 0, 0, .nan", ":6: T_BS.data.3: must be finite"},
    {"cam0", "[1, 0, 0, 0.0", "[1.01, 0, 0, 0.0", ":3: T_BS: rotation is not orthonormal: off by 0.02, allowed 0.001"},
    {"cam0", "[1, 0, 0, 0.0", "[-1, 0, 0, 0.0", ":3: T_BS: rotation is a reflection (determinant -1)"},
    {"cam0", "0, 0, 0, 1]", "0, 0, 0.1, 1]", ":3: T_BS: last row must be 0 0 0 1"},
    {"cam1", "[1, 0, 0, 0.1", "[1, 0, 0, 0.0005",
     ":3: T_BS: baseline between the cameras is 0.0005 m, must be 0.001 to 10 m"},
    {"cam1", "[1, 0, 0, 0.1", "[1, 0, 0, 100",
     ":3: T_BS: baseline between the cameras is 100 m, must be 0.001 to 10 m"},
    {"cam1", "resolution: [160, 120]", "resolution: [160, -120]", ":11: resolution: must be two positive integers"},
    {"cam1", "resolution: [160, 120]", "resolution: [160.5, 120]", ":11: resolution: must be two positive integers"},
    {"cam1", "resolution: [160, 120]", "resolution: 160x120", ":11: resolution: must be a list of 2 numbers"},
    {"cam1", "pinhole", "spline", ":12: camera_model: unknown model 'spline': pinhole, omni, ds or eucm"},
    {"cam1", "pinhole", "omni", ":13: intrinsics: must be a list of 5 numbers"},
    {"cam1", "intrinsics: [150.0", "intrinsics: [-150.0", ":13: intrinsics: focal lengths must be positive"},
    {"cam1", "resolution: [160, 120]", "resolution: [1e300, 120]", ":11: resolution: must be two positive integers"},
    {"cam1", "intrinsics: [150.0", "intrinsics: [1.0",
     ":13: intrinsics: focal lengths of 1 and 150 px do not belong to 160x120 px: must be 16 to 3200"},
    {"cam1", "intrinsics: [150.0", "intrinsics: [1e300",
     ":13: intrinsics: focal lengths of 1e+300 and 150 px do not belong to 160x120 px: must be 16 to 3200"},
    {"cam1", "intrinsics: [150.0, ", "intrinsics: [", ":13: intrinsics: must be a list of 4 numbers"},
    {"cam1", "radial-tangential", "spline",
     ":14: distortion_model: unknown model 'spline': radial-tangential (radtan, plumb_bob; 4, 5 or 8 coefficients), "
     "equidistant (fisheye), fov or none"},
    {"cam1", "radial-tangential", "fov", ":15: distortion_coefficients: must be a list of 1 numbers"},
    {"cam1", "[-0.1, 0.01, 0.0, 0.0]", "[-0.1, 0.01]",
     ":15: distortion_coefficients: must be a list of 4, 5 or 8 numbers: k1 k2 p1 p2 (k3 (k4 k5 k6))"},
    {"cam1", "[-0.1, 0.01, 0.0, 0.0]", "[-5.0, 0.01, 0.0, 0.0]",
     ":15: distortion_coefficients: distortion is not increasing up to the image corner"},
    {"cam1", "intrinsics:", "camera_model: pinhole\nintrinsics:", ":13: camera_model: given twice"},
    {"imu0", "rate_hz: 200", "rate_hz: 0", ":10: rate_hz: must be within [20, 10000] Hz, is 0"},
    {"imu0", "1.7e-4", "-1.7e-4",
     ":11: gyroscope_noise_density: must be within [1e-07, 1] rad/s/sqrt(Hz), is -0.00017"},
    {"imu0", "gyroscope_random_walk: 1.9e-5\n", "", ":1: gyroscope_random_walk: missing"},
    {"imu0", "accelerometer_random_walk: 3.0e-3", "accelerometer_random_walk: -1",
     ":14: accelerometer_random_walk: must be within [1e-08, 10] m/s^3/sqrt(Hz), is -1"},
};

TEST_CASE("every bad or missing field is one error with file, line and field") {
    const BadField& bad = GENERATE(from_range(std::begin(kBadFields), std::end(kBadFields)));
    const test::TempDir dir;
    write_euroc(dir);
    const std::string name = std::string(bad.file) + "/sensor.yaml";
    dir.write(name, replaced(test::read_file(dir.file(name)), bad.from, bad.to));
    CHECK(input_error_text([&] { load_euroc_calibration(dir.path()); }) == dir.file(name) + bad.complaint);
}

TEST_CASE("missing files and broken YAML are named") {
    const test::TempDir dir;
    write_euroc(dir);
    std::filesystem::remove(dir.file("cam1/sensor.yaml"));
    CHECK(input_error_text([&] { load_euroc_calibration(dir.path()); }) ==
          dir.file("cam1/sensor.yaml") + ": cannot be read");
    dir.write("cam1/sensor.yaml", "a: 1\nb: [1, 2\nc: 3\n");
    const std::string text = input_error_text([&] { load_euroc_calibration(dir.path()); });
    CHECK(text.starts_with(dir.file("cam1/sensor.yaml") + ":3: not valid YAML: "));
    dir.write("cam1/sensor.yaml", "- 1\n- 2\n");
    CHECK(input_error_text([&] { load_euroc_calibration(dir.path()); }) ==
          dir.file("cam1/sensor.yaml") + ":1: is not a map of keys to values");
}

const char* const kCamchain =
    "cam0:\n"
    "  T_cam_imu:\n"
    "  - [0, 0, 1, 0.5]\n"
    "  - [1, 0, 0, 0]\n"
    "  - [0, 1, 0, 0]\n"
    "  - [0, 0, 0, 1]\n"
    "  cam_overlaps: [1]\n"
    "  camera_model: pinhole\n"
    "  distortion_coeffs: [0.01, 0.002, 0.0, 0.0]\n"
    "  distortion_model: equidistant\n"
    "  intrinsics: [400, 401, 319, 239]\n"
    "  resolution: [640, 480]\n"
    "  timeshift_cam_imu: -0.0075\n"
    "cam1:\n"
    "  T_cam_imu:\n"
    "  - [0, 0, 1, 0.4]\n"
    "  - [1, 0, 0, 0]\n"
    "  - [0, 1, 0, 0]\n"
    "  - [0, 0, 0, 1]\n"
    "  T_cn_cnm1:\n"
    "  - [1, 0, 0, -0.1]\n"
    "  - [0, 1, 0, 0]\n"
    "  - [0, 0, 1, 0]\n"
    "  - [0, 0, 0, 1]\n"
    "  camera_model: pinhole\n"
    "  distortion_model: none\n"
    "  distortion_coeffs: []\n"
    "  intrinsics: [400, 401, 319, 239]\n"
    "  resolution: [640, 480]\n";
const char* const kKalibrImu =
    "accelerometer_noise_density: 0.01\naccelerometer_random_walk: 0.0002\ngyroscope_noise_density: 0.005\n"
    "gyroscope_random_walk: 4.0e-06\nrostopic: /imu0\nupdate_rate: 250.0\n";

TEST_CASE("Kalibr's T_cam_imu is inverted: it maps IMU to camera") {
    const test::TempDir dir;
    const std::string imu = dir.write("imu.yaml", kKalibrImu);
    const std::string camchain = dir.write("camchain.yaml", kCamchain);
    const Calibration c = load_kalibr_calibration(camchain, imu);
    // p_C0 = (z_B + 0.5, x_B, y_B), so the camera's centre p_C0 = 0 is at z_B = -0.5.
    CHECK((c.rig.T_B_C0.p - Eigen::Vector3d(0, 0, -0.5)).norm() < 1e-12);
    CHECK((c.rig.T_B_C0 * Eigen::Vector3d(0, 1, 0) - Eigen::Vector3d(1, 0, -0.5)).norm() < 1e-12);
    CHECK(c.rig.baseline_m() == Approx(0.1));
    CHECK((c.rig.T_C1_C0().p - Eigen::Vector3d(-0.1, 0, 0)).norm() < 1e-12);
    CHECK(c.rig.left.intrinsics().distortion == Distortion::kEquidistant);
    CHECK(c.rig.right.intrinsics().distortion == Distortion::kNone);
    CHECK(c.camera_time_shift.ns == -7'500'000);
    CHECK(c.noise.rate_hz == 250.0);
    CHECK(c.noise.accel_noise_m_per_s2_per_sqrt_hz == 0.01);
    CHECK(c.noise.gyro_walk_rad_per_s2_per_sqrt_hz == 4.0e-6);

    // T_cn_cnm1 alone gives the same right camera.
    const std::string chained = dir.write(
        "chained.yaml",
        replaced(kCamchain, "  T_cam_imu:\n  - [0, 0, 1, 0.4]\n  - [1, 0, 0, 0]\n  - [0, 1, 0, 0]\n  - [0, 0, 0, 1]\n",
                 ""));
    const Calibration d = load_kalibr_calibration(chained, imu);
    CHECK((d.rig.T_B_C1.matrix() - c.rig.T_B_C1.matrix()).norm() < 1e-12);
}

TEST_CASE("Kalibr files name what is missing") {
    const test::TempDir dir;
    const std::string imu = dir.write("imu.yaml", kKalibrImu);
    const auto complaint = [&](const std::string& from, const std::string& to) {
        const std::string path = dir.write("camchain.yaml", replaced(kCamchain, from, to));
        return input_error_text([&] { load_kalibr_calibration(path, imu); });
    };
    const std::string path = dir.file("camchain.yaml");
    CHECK(complaint("cam1:", "cam2:").find("cam2: is there without cam1") != std::string::npos);
    const std::string alone =
        dir.write("alone.yaml", std::string(kCamchain).substr(0, std::string(kCamchain).find("cam1:")));
    CHECK_FALSE(load_kalibr_calibration(alone, imu).rig.has_right);  // a vehicle with one camera
    const std::string odd = dir.write("odd.yaml", replaced(kCamchain, "cam1:", "[cam1]:"));
    CHECK_FALSE(load_kalibr_calibration(odd, imu).rig.has_right);  // a key that is no text is none of ours
    CHECK(complaint("cam0:\n  T_cam_imu", "cam0:\n  T_imu").find(path + ":1: cam0: T_cam_imu: missing") == 0);
    CHECK(complaint("timeshift_cam_imu: -0.0075", "timeshift_cam_imu: 12") ==
          path + ":13: cam0.timeshift_cam_imu: more than 1 s: cameras and IMU are not on one clock");
    CHECK(complaint("resolution: [640, 480]\n  timeshift", "timeshift") == path + ":1: cam0.resolution: missing");
    const std::string bad_imu = dir.write("imu.yaml", replaced(kKalibrImu, "update_rate: 250.0", "update_rate: fast"));
    const std::string good = dir.write("camchain.yaml", kCamchain);
    CHECK(input_error_text([&] { load_kalibr_calibration(good, bad_imu); }) ==
          bad_imu + ":6: update_rate: must be a number");
}

TEST_CASE("a log's calibration may come from another folder, time shift included") {
    const test::TempDir log;
    write_euroc(log);
    const test::TempDir other;
    write_euroc(other);
    other.write("cam0/sensor.yaml", replaced(test::asl_camera_yaml(0), "150", "151") + "\ntimeshift_cam_imu: 0.004\n");
    CHECK(load_calibration(log.path(), "", "").rig.left.intrinsics().fx == 150.0);
    const Calibration c = load_calibration(log.path(), other.path(), "");
    CHECK(c.rig.left.intrinsics().fx == 151.0);
    CHECK(c.camera_time_shift == Duration::from_seconds(0.004));
    CHECK(c.source == other.path());
    CHECK(input_error_text([&] { load_calibration(log.path(), log.file("none.yaml"), ""); }).find("none.yaml") !=
          std::string::npos);
}

TEST_CASE("a log keeps the files of its calibration, EuRoC's or Kalibr's") {
    const test::TempDir given;
    write_euroc(given);
    const std::string camchain = given.write("camchain-imucam.yaml", kCamchain);
    const std::string imu = given.write("imu-of-the-vehicle.yaml", kKalibrImu);
    const bool is_kalibr = GENERATE(false, true);
    const Calibration c =
        is_kalibr ? load_kalibr_calibration(camchain, imu) : load_calibration("unused", given.path(), "");
    const test::TempDir log;
    for (const char* folder : {"cam0", "cam1", "imu0"}) {
        std::filesystem::create_directory(log.file(folder));
    }
    keep_calibration(c, log.path());
    const Calibration again = load_calibration(log.path(), "", "");
    CHECK(again.rig.T_B_C1.p == c.rig.T_B_C1.p);
    CHECK(again.rig.T_B_C1.q.coeffs() == c.rig.T_B_C1.q.coeffs());
    CHECK(again.rig.right.intrinsics().coeffs == c.rig.right.intrinsics().coeffs);
    CHECK(again.noise.rate_hz == c.noise.rate_hz);
    CHECK(again.camera_time_shift == c.camera_time_shift);
    CHECK(std::filesystem::exists(log.file("camchain.yaml")) == is_kalibr);
    CHECK(input_error_text([&] { keep_calibration(c, log.path()); }).find("cannot be copied") != std::string::npos);
}

TEST_CASE("standard deviations are read if both cameras state them") {
    const test::TempDir dir;
    write_euroc(dir);
    const std::string stated =
        "\nintrinsics_sigma: [0.03, 0.015, 0.05, 0.08]\ndistortion_sigma: [1e-4, 2e-4, 1e-2, 1e-2]\n"
        "rotation_sigma_deg: [0.01, 0.02, 0.01]\n";
    dir.write("cam0/sensor.yaml", test::asl_camera_yaml(0) + stated);
    CHECK_FALSE(load_euroc_calibration(dir.path()).sigmas.has_value());
    dir.write("cam1/sensor.yaml", test::asl_camera_yaml(1) + replaced(stated, "0.05", "0.09"));
    const Calibration c = load_euroc_calibration(dir.path());
    REQUIRE(c.sigmas.has_value());
    CHECK(c.sigmas->focal == Approx(2e-4));
    CHECK(c.sigmas->principal_px == 0.09);
    CHECK(c.sigmas->distortion == 2e-4);
    CHECK(c.sigmas->late_distortion == 1e-2);
    CHECK(c.sigmas->rotation_rad == Approx(3.4907e-4).epsilon(1e-3));
    ProgramConfig config;
    take_calibration(c, config);
    CHECK(config.calibration.principal_sigma_px == 0.09);
    CHECK(config.calibration.late_distortion_sigma == 1e-2);
    CHECK(config.calibration.camera_position_sigma_m == CalibrationConfig{}.camera_position_sigma_m);
    CHECK(config.imu_noise.rate_hz == c.noise.rate_hz);
    CHECK(ok(config.validate()));
}

}  // namespace
}  // namespace facet::calibration_test
