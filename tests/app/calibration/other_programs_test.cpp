// SPDX-License-Identifier: BSD-2-Clause
// The calibrations that other programs write: one rig in every form, and files that are none.
#include <catch2/catch.hpp>
#include <filesystem>

#include "app/calibration/calibration.h"
#include "app/calibration/calibration_writer.h"
#include "app/config/calibrated_config.h"
#include "tests/support/asl_folder.h"
#include "tests/support/input_error_text.h"
#include "tests/support/temp_dir.h"

namespace facet::other_programs_test {
namespace {

using test::input_error_text;

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    REQUIRE(at != std::string::npos);
    return text.replace(at, from.size(), to);
}

// The left camera looks along the IMU's x axis, 5 cm ahead: x_C = -y_B, y_C = -z_B, z_C = x_B - 0.05. The right one is
// 0.1 m beside it.
const char* const kCamImu0 = "[[0, -1, 0, 0], [0, 0, -1, 0], [1, 0, 0, -0.05], [0, 0, 0, 1]]";
const char* const kCamImu1 = "[[0, -1, 0, -0.1], [0, 0, -1, 0], [1, 0, 0, -0.05], [0, 0, 0, 1]]";
const char* const kImuCam0 = "[0, 0, 1, 0.05, -1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 0, 1]";
const char* const kImuCam1 = "[0, 0, 1, 0.05, -1, 0, 0, -0.1, 0, -1, 0, 0, 0, 0, 0, 1]";

std::string opencv(const std::string& values, int side = 4) {
    const std::string n = std::to_string(side);
    return "!!opencv-matrix\n   rows: " + n + "\n   cols: " + n + "\n   dt: d\n   data: " + values + "\n";
}

std::string chain_camera(const std::string& mount, const std::string& lens) {
    return "  " + mount + "\n  " + lens + "\n  resolution: [640, 480]\n  rostopic: /cam\n";
}
const char* const kRadtan =
    "camera_model: pinhole\n  intrinsics: [400, 401, 319, 239]\n  distortion_model: radtan\n"
    "  distortion_coeffs: [-0.28, 0.07, 0.0002, 0.00001]";

std::string chain(const std::string& lens = kRadtan) {
    return "cam0:\n" + chain_camera("T_cam_imu: " + std::string(kCamImu0), lens) + "cam1:\n" +
           chain_camera("T_cam_imu: " + std::string(kCamImu1), lens);
}

const char* const kNoise =
    "accelerometer_noise_density: 0.01\naccelerometer_random_walk: 0.0002\ngyroscope_noise_density: 0.005\n"
    "gyroscope_random_walk: 4.0e-06\nrostopic: /imu0\nupdate_rate: 250.0\n";

void check_rig(const Calibration& c) {
    CHECK(c.rig.has_right);
    CHECK((c.rig.T_B_C0 * Eigen::Vector3d(0.1, 0.2, 1.0) - Eigen::Vector3d(1.05, -0.1, -0.2)).norm() < 1e-9);
    CHECK((c.rig.T_C1_C0().p - Eigen::Vector3d(-0.1, 0.0, 0.0)).norm() < 1e-9);
    const CameraIntrinsics& k = c.rig.left.intrinsics();
    CHECK(k.width == 640);
    CHECK(k.height == 480);
    CHECK(k.fx == Approx(400.0));
    CHECK(k.fy == Approx(401.0));
    CHECK(k.cx == Approx(319.0));
    CHECK(k.cy == Approx(239.0));
}

void check_radtan(const CameraModel& camera) {
    CHECK(camera.intrinsics().distortion == Distortion::kRadialTangential);
    CHECK(camera.intrinsics().coeffs == std::array{-0.28, 0.07, 0.0002, 0.00001});
}

void check_noise(const ImuNoise& noise) {
    CHECK(noise.accel_noise_m_per_s2_per_sqrt_hz == 0.01);
    CHECK(noise.accel_walk_m_per_s3_per_sqrt_hz == 0.0002);
    CHECK(noise.gyro_noise_rad_per_s_per_sqrt_hz == 0.005);
    CHECK(noise.gyro_walk_rad_per_s2_per_sqrt_hz == 4e-6);
    CHECK(noise.rate_hz == 250.0);
}

}  // namespace

TEST_CASE("OpenVINS: T_imu_cam maps camera to IMU") {
    const test::TempDir dir;
    const std::string path =
        dir.write("chain.yaml", "%YAML:1.0\n\ncam0:\n" + chain_camera("T_imu_cam: " + std::string(kImuCam0), kRadtan) +
                                    "cam1:\n" + chain_camera("T_imu_cam: " + std::string(kImuCam1), kRadtan));
    const Calibration c = load_calibration(dir.path(), path, dir.write("imu.yaml", kNoise));
    check_rig(c);
    check_radtan(c.rig.left);
    check_noise(c.noise);
    CHECK(c.remarks.empty());
}

TEST_CASE("Kalibr: every lens model that it writes") {
    struct Case {
        const char* lens;
        Distortion distortion;
        std::array<double, 4> coeffs;
        std::array<double, 4> more;
    };
    const std::string plane = "intrinsics: [400, 401, 319, 239]\n  ";
    const auto pinhole = [&](const char* model, const char* coefficients) {
        return "camera_model: pinhole\n  " + plane + "distortion_model: " + model +
               "\n  distortion_coeffs: " + coefficients;
    };
    const std::string plumb4 = pinhole("plumb_bob", "[-0.28, 0.07, 0.0002, 0.00001]");
    const std::string plumb5 = pinhole("plumb_bob", "[-0.28, 0.07, 0.0002, 0.00001, 0.0]");
    const std::string plumb5_used = pinhole("plumb_bob", "[-0.28, 0.07, 0.0002, 0.00001, 0.004]");
    const std::string rational = pinhole("rational_polynomial", "[4.8, 2.9, 0.0002, 0.00001, 0.13, 5.1, 4.6, 0.7]");
    const std::string rational0 = pinhole("rational_polynomial", "[-0.28, 0.07, 0.0002, 0.00001, 0, 0, 0, 0]");
    const std::string fisheye = pinhole("fisheye", "[0.01, 0.02, 0.003, 0.004]");
    const std::string fov = pinhole("fov", "[0.93]");
    const std::string omni =
        "camera_model: omni\n  intrinsics: [1.1, 400, 401, 319, 239]\n  distortion_model: radtan\n"
        "  distortion_coeffs: [-0.1, 0.2, 0.0002, 0.00001]";
    const std::string ds =
        "camera_model: ds\n  intrinsics: [-0.2, 0.59, 400, 401, 319, 239]\n  distortion_model: none\n"
        "  distortion_coeffs: []";
    const std::string eucm = "camera_model: eucm\n  intrinsics: [0.62, 1.05, 400, 401, 319, 239]";
    const Case cases[] = {
        {plumb4.c_str(), Distortion::kRadialTangential, {-0.28, 0.07, 0.0002, 0.00001}, {}},
        {plumb5.c_str(), Distortion::kRadialTangential, {-0.28, 0.07, 0.0002, 0.00001}, {}},
        {plumb5_used.c_str(), Distortion::kRational, {-0.28, 0.07, 0.0002, 0.00001}, {0.004, 0.0, 0.0, 0.0}},
        {rational.c_str(), Distortion::kRational, {4.8, 2.9, 0.0002, 0.00001}, {0.13, 5.1, 4.6, 0.7}},
        {rational0.c_str(), Distortion::kRadialTangential, {-0.28, 0.07, 0.0002, 0.00001}, {}},
        {fisheye.c_str(), Distortion::kEquidistant, {0.01, 0.02, 0.003, 0.004}, {}},
        {fov.c_str(), Distortion::kFov, {0.93, 0.0, 0.0, 0.0}, {}},
        {omni.c_str(), Distortion::kUnified, {-0.1, 0.2, 0.0002, 0.00001}, {1.1, 0.0, 0.0, 0.0}},
        {ds.c_str(), Distortion::kDoubleSphere, {-0.2, 0.59, 0.0, 0.0}, {}},
        {eucm.c_str(), Distortion::kEucm, {0.62, 1.05, 0.0, 0.0}, {}},
    };
    for (const Case& expected : cases) {
        CAPTURE(expected.lens);
        const test::TempDir dir;
        const std::string imu = dir.write("imu.yaml", kNoise);
        const Calibration c = load_calibration(dir.path(), dir.write("chain.yaml", chain(expected.lens)), imu);
        check_rig(c);
        CHECK(c.rig.left.intrinsics().distortion == expected.distortion);
        CHECK(c.rig.left.intrinsics().coeffs == expected.coeffs);
        CHECK(c.rig.left.intrinsics().more == expected.more);
        // What is written of it is read again, in both forms.
        write_kalibr_files(c, dir.file("kalibr"));
        write_sensor_files(c, dir.file("euroc"));
        for (const Calibration& again :
             {load_calibration(dir.path(), dir.file("kalibr/camchain-imucam.yaml"), dir.file("kalibr/imu.yaml")),
              load_calibration(dir.path(), dir.file("euroc"), "")}) {
            check_rig(again);
            check_noise(again.noise);
            CHECK(again.rig.right.intrinsics().distortion == expected.distortion);
            CHECK(again.rig.right.intrinsics().coeffs == expected.coeffs);
            CHECK(again.rig.right.intrinsics().more == expected.more);
        }
    }
}

TEST_CASE("an invalid lens is refused with what is wrong, and where") {
    const test::TempDir dir;
    const std::string imu = dir.write("imu.yaml", kNoise);
    const auto complaint = [&](const std::string& from, const std::string& to) {
        const std::string path = dir.write("chain.yaml", replaced(chain(), from, to));
        std::string text = input_error_text([&] { load_calibration(dir.path(), path, imu); });
        return text.substr(std::min(path.size(), text.size()));
    };
    CHECK(complaint("radtan", "spline").find(":5: cam0.distortion_model: unknown model 'spline'") == 0);
    CHECK(complaint("pinhole", "scaramuzza").find(":3: cam0.camera_model: unknown model 'scaramuzza'") == 0);
    CHECK(complaint("[-0.28, 0.07, 0.0002, 0.00001]", "[-0.28, 0.07]")
              .find(":6: cam0.distortion_coeffs: must be a list of 4, 5 or 8 numbers") == 0);
    CHECK(complaint("[-0.28, 0.07, 0.0002, 0.00001]", "[-0.28, 0.07, 0, 0, 0, 0, 0, 0, 0.1, 0, 0, 0]")
              .find("a thin prism or a tilted sensor") != std::string::npos);
    CHECK(complaint("[400, 401, 319, 239]", "[1.1, 400, 401, 319, 239]")
              .find(":4: cam0.intrinsics: must be a list of 4 numbers") == 0);
}

TEST_CASE("scale, misalignment and sensitivity of the IMU are read and applied: Kalibr and OpenVINS") {
    const std::string kalibr = std::string("imu0:\n  ") +
                               "T_i_b: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n"
                               "  accelerometers:\n    M: [[1.03, 0, 0], [0.02, 0.97, 0], [-0.02, 0.01, 1.02]]\n"
                               "  gyroscopes:\n    M: [[0.97, 0, 0], [0.01, 1.03, 0], [0, -0.02, 1.02]]\n"
                               "    A: [[0.001, 0, 0], [0, 0, 0.002], [0, 0, 0]]\n"
                               "    C_gyro_i: [[0, -1, 0], [1, 0, 0], [0, 0, 1]]\n"
                               "  model: scale-misalignment\n";
    // The same sensor; OpenVINS's sensitivity is by the force in the body's axes: Tg = A C_gyro_i.
    const std::string openvins = std::string("imu0:\n  model: \"kalibr\"\n") +
                                 "  Ta: [[1.03, 0, 0], [0.02, 0.97, 0], [-0.02, 0.01, 1.02]]\n"
                                 "  R_IMUtoACC: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n"
                                 "  Tw: [[0.97, 0, 0], [0.01, 1.03, 0], [0, -0.02, 1.02]]\n"
                                 "  R_IMUtoGYRO: [[0, -1, 0], [1, 0, 0], [0, 0, 1]]\n"
                                 "  Tg: [[0, -0.001, 0], [0, 0, 0.002], [0, 0, 0]]\n";
    std::string noise = "  " + std::string(kNoise);
    for (std::size_t at = noise.find('\n'); at + 1 < noise.size(); at = noise.find('\n', at + 1)) {
        noise.insert(at + 1, "  ");
    }
    Eigen::Matrix3d M_a;
    Eigen::Matrix3d M_w;
    Eigen::Matrix3d A;
    Eigen::Matrix3d C;
    M_a << 1.03, 0, 0, 0.02, 0.97, 0, -0.02, 0.01, 1.02;
    M_w << 0.97, 0, 0, 0.01, 1.03, 0, 0, -0.02, 1.02;
    A << 0.001, 0, 0, 0, 0, 0.002, 0, 0, 0;
    C << 0, -1, 0, 1, 0, 0, 0, 0, 1;
    const Eigen::Vector3d w(0.4, -0.7, 1.1);
    const Eigen::Vector3d a(1.0, -2.0, 9.5);
    for (const std::string& text : {kalibr, openvins}) {
        const test::TempDir dir;
        Calibration c;
        load_kalibr_imu(dir.write("imu.yaml", text + noise), c);
        CHECK(c.remarks.empty());
        check_noise(c.noise);
        // Kalibr's equations (scale-misalignment): w_m = M (C w) + A (C a), a_m = M a.
        const ImuSample read = c.imu_model.corrected({{7}, M_w * C * w + A * C * a, M_a * a});
        CHECK((read.w_B - w).norm() < 1e-12);
        CHECK((read.a_B - a).norm() < 1e-12);
        CHECK(read.stamp.ns == 7);
        // It goes on into the estimator's configuration, and into what is written.
        ProgramConfig config;
        take_calibration(c, config);
        CHECK_FALSE(config.imu_model.is_ideal());
        c.rig = StereoRig::monocular(CameraModel({640, 480, 400.0, 400.0, 320.0, 240.0, Distortion::kNone, {}}), {});
        write_sensor_files(c, dir.path());
        write_kalibr_files(c, dir.path());
        for (const Calibration& again :
             {load_calibration(dir.path(), dir.path(), ""),
              load_calibration("", dir.file("camchain-imucam.yaml"), dir.file("imu.yaml"))}) {
            CHECK(again.imu_model.M_w().isApprox(c.imu_model.M_w(), 1e-11));
            CHECK(again.imu_model.M_g().isApprox(c.imu_model.M_g(), 1e-11));
            CHECK(again.imu_model.M_a().isApprox(c.imu_model.M_a(), 1e-11));
        }
    }
}

TEST_CASE("an ideal IMU's samples are untouched, and a reading that is NaN spoils only itself") {
    const ImuSample sample{{7}, {0.1, std::nan(""), 0.3}, {1.0, 2.0, 3.0}};
    CHECK(ImuModel().corrected(sample).a_B == sample.a_B);
    CHECK(ImuModel().is_ideal());
    const ImuModel scaled(1.1 * Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Zero());
    CHECK(scaled.corrected(sample).a_B.allFinite());
    CHECK(scaled.corrected({{7}, {0.1, 0.2, 0.3}, {std::nan(""), 0.0, 0.0}}).w_B == Eigen::Vector3d(0.1, 0.2, 0.3));
}

TEST_CASE("what an IMU's file holds and is not used is named; nonsense is refused") {
    const test::TempDir dir;
    const auto load = [&](const std::string& extra) {
        Calibration c;
        load_kalibr_imu(dir.write("imu.yaml", kNoise + extra), c);
        return c.remarks;
    };
    const std::string path = dir.file("imu.yaml");
    CHECK(load("") == std::vector<std::string>{});
    CHECK(load("accelerometers: {M: [[1, 0, 0], [0, 1, 0], [0, 0, 1]], ry_i: [0.01, 0, 0]}\n") ==
          std::vector<std::string>{path + ":7: accelerometers.ry_i: is not used"});
    CHECK(load("time_offset: 0.01\n") == std::vector<std::string>{path + ":7: time_offset: is not used"});
    CHECK(input_error_text([&] { load("Tw: [[1, 0, 0], [0, 1, 0]]\n"); }) == path + ":7: Tw: must be a 3x3 matrix");
    CHECK(input_error_text([&] {
              load("Tw: [[3, 0, 0], [0, 1, 0], [0, 0, 1]]\n");
          }).find("misalignment of the gyroscope are off by more than a half") != std::string::npos);
    CHECK(input_error_text([&] { load("Ta: [[-1, 0, 0], [0, 1, 0], [0, 0, 1]]\n"); }).find("accelerometer") !=
          std::string::npos);
    CHECK(input_error_text([&] {
              load("gyroscopes: {C_gyro_i: [[1, 0, 0], [0, 2, 0], [0, 0, 1]]}\n");
          }).find("gyroscopes.C_gyro_i: rotation is not orthonormal") != std::string::npos);
    CHECK(input_error_text([&] {
              load("T_i_b: [[1, 0, 0, 1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n");
          }).find("those of another IMU") != std::string::npos);
}

const char* const kBasalt = R"({"value0": {
  "T_imu_cam": [
    {"px": 0.05, "py": 0, "pz": 0, "qx": 0.5, "qy": -0.5, "qz": 0.5, "qw": -0.5},
    {"px": 0.05, "py": -0.1, "pz": 0, "qx": 0.5, "qy": -0.5, "qz": 0.5, "qw": -0.5}],
  "intrinsics": [
    {"camera_type": "ds", "intrinsics": {"fx": 400, "fy": 401, "cx": 319, "cy": 239, "xi": -0.2, "alpha": 0.59}},
    {"camera_type": "kb4", "intrinsics": {"fx": 400, "fy": 401, "cx": 319, "cy": 239, "k1": 0.01, "k2": 0.02,
      "k3": 0.003, "k4": 0.004}}],
  "resolution": [[640, 480], [640, 480]],
  "calib_accel_bias": [0.1, 0.2, 0.3, 0.01, 0.002, 0.003, 0.02, 0.004, 0.03],
  "calib_gyro_bias": [0, 0, 0, 0.01, 0.001, 0.002, 0.003, 0.02, 0.004, 0.005, 0.006, 0.03],
  "imu_update_rate": 250.0,
  "accel_noise_std": [0.01, 0.01, 0.01], "gyro_noise_std": [0.005, 0.005, 0.005],
  "accel_bias_std": [0.0002, 0.0002, 0.0002], "gyro_bias_std": [4e-06, 4e-06, 4e-06],
  "cam_time_offset_ns": 5000000, "vignette": []}}
)";

TEST_CASE("Basalt: cameras, IMU and time in one file") {
    const test::TempDir dir;
    const Calibration c = load_calibration(dir.path(), dir.write("calib.json", kBasalt), "");
    check_rig(c);
    check_noise(c.noise);
    CHECK(c.rig.left.intrinsics().distortion == Distortion::kDoubleSphere);
    CHECK(c.rig.left.intrinsics().coeffs[1] == 0.59);
    CHECK(c.rig.right.intrinsics().distortion == Distortion::kEquidistant);
    CHECK(c.camera_time_shift.ns == 5'000'000);
    Eigen::Matrix3d scale;  // Basalt's (1 + S) a_m
    scale << 1.01, 0, 0, 0.002, 1.02, 0, 0.003, 0.004, 1.03;
    const Eigen::Vector3d measured(1.0, -2.0, 9.0);
    CHECK((c.imu_model.corrected({{}, {}, measured}).a_B - scale * measured).norm() < 1e-12);
    scale << 1.01, 0.003, 0.005, 0.001, 1.02, 0.006, 0.002, 0.004, 1.03;
    CHECK((c.imu_model.corrected({{}, measured, {}}).w_B - scale * measured).norm() < 1e-12);
    const std::string odd = dir.write("odd.json", replaced(kBasalt, "\"kb4\"", "\"spline\""));
    CHECK(input_error_text([&] { load_calibration(dir.path(), odd, ""); }).find("unknown model 'spline'") !=
          std::string::npos);
}

TEST_CASE("ORB-SLAM3: settings with an IMU") {
    const test::TempDir dir;
    const auto camera = [](const std::string& n) {
        return "Camera" + n + ".fx: 400.0\nCamera" + n + ".fy: 401.0\nCamera" + n + ".cx: 319.0\nCamera" + n +
               ".cy: 239.0\nCamera" + n + ".k1: -0.28\nCamera" + n + ".k2: 0.07\nCamera" + n + ".p1: 0.0002\nCamera" +
               n + ".p2: 0.00001\n";
    };
    const std::string text = "%YAML:1.0\n---\nFile.version: \"1.0\"\nCamera.type: \"PinHole\"\n" + camera("1") +
                             camera("2") + "Camera.width: 640\nCamera.height: 480\nCamera.fps: 20\n" +
                             "Stereo.T_c1_c2: " + opencv("[1, 0, 0, 0.1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]") +
                             "IMU.T_b_c1: " + opencv(kImuCam0) +
                             "IMU.NoiseGyro: 0.005\nIMU.NoiseAcc: 0.01\nIMU.GyroWalk: 4.0e-06\nIMU.AccWalk: 0.0002\n"
                             "IMU.Frequency: 250.0\n";
    const Calibration c = load_calibration(dir.path(), dir.write("stereo_inertial.yaml", text), "");
    check_rig(c);
    check_radtan(c.rig.right);
    check_noise(c.noise);
    CHECK(c.remarks.empty());
    const std::string alone = dir.write("mono.yaml", replaced(text, "IMU.T_b_c1", "IMU.T_b_c9"));
    CHECK(input_error_text([&] { load_calibration(dir.path(), alone, ""); }).find("IMU.T_b_c1 is missing") !=
          std::string::npos);
}

TEST_CASE("VINS-Fusion: a configuration and the lenses that it names") {
    const test::TempDir dir;
    const std::string lens =
        "%YAML:1.0\n---\nmodel_type: PINHOLE\ncamera_name: camera\nimage_width: 640\nimage_height: 480\n"
        "distortion_parameters:\n   k1: -0.28\n   k2: 0.07\n   p1: 0.0002\n   p2: 0.00001\n"
        "projection_parameters:\n   fx: 400.0\n   fy: 401.0\n   cx: 319.0\n   cy: 239.0\n";
    const std::string config =
        dir.write("config.yaml",
                  "%YAML:1.0\nimu: 1\nnum_of_cam: 2\ncam0_calib: \"cam0.yaml\"\ncam1_calib: \"cam1.yaml\"\n"
                  "body_T_cam0: " +
                      opencv(kImuCam0) + "body_T_cam1: " + opencv(kImuCam1) + "acc_n: 0.1\ngyr_n: 0.01\ntd: 0.004\n");
    dir.write("cam0.yaml", lens);
    dir.write("cam1.yaml", lens);
    dir.write("imu0/data.csv", "#timestamp\n1000000000,0,0,0,0,0,9.8\n1010000000,0,0,0,0,0,9.8\n1020000000,0,0\n");
    const Calibration c = load_calibration(dir.path(), config, "");
    check_rig(c);
    check_radtan(c.rig.right);
    CHECK(c.camera_time_shift.ns == 4'000'000);
    // Nothing says how noisy the IMU is: assumed, at the rate of the log's samples, and told.
    CHECK(c.noise.rate_hz == Approx(100.0));
    REQUIRE(c.remarks.size() == 2);
    CHECK(c.remarks[1].find("no file says how noisy the IMU is") == 0);
    dir.write("cam1.yaml",
              "model_type: MEI\nimage_width: 640\nimage_height: 480\nmirror_parameters:\n   xi: 1.1\n"
              "distortion_parameters:\n   k1: -0.1\n   k2: 0.2\n   p1: 0\n   p2: 0\n"
              "projection_parameters:\n   gamma1: 400\n   gamma2: 401\n   u0: 319\n   v0: 239\n");
    CHECK(load_calibration(dir.path(), config, "").rig.right.intrinsics().more[0] == 1.1);
    CHECK(input_error_text([&] {
              load_calibration(dir.path(), dir.file("cam0.yaml"), "");
          }).find("is the lens of one camera as camodocal writes it: give the configuration of VINS") !=
          std::string::npos);
}

TEST_CASE("older forms: VINS-Mono's one file, ORB-SLAM3's Tlr, CRLF, a byte order mark, comments first") {
    const test::TempDir dir;
    const std::string vins =
        "\xEF\xBB\xBF# a comment\r\n%YAML:1.0\r\n---\r\nextrinsicTranslation: " +
        std::string("!!opencv-matrix\r\n   rows: 3\r\n   cols: 1\r\n   dt: d\r\n   data: [0.05, 0, 0]\r\n") +
        "extrinsicRotation: !!opencv-matrix\r\n   data: [0, 0, 1, -1, 0, 0, 0, -1, 0]\r\n   rows: 3\r\n   cols: 3\r\n"
        "projection_parameters:\r\n   cy: 239.0\r\n   cx: 319.0\r\n   fx: 400.0\r\n   fy: 401.0\r\n"
        "distortion_parameters:\r\n   k1: -0.28\r\n   k2: 0.07\r\n   p1: 0.0002\r\n   p2: 0.00001\r\n"
        "model_type: PINHOLE\r\nimage_width: 640\r\nimage_height: 480\r\n";
    const Calibration mono = load_calibration(dir.path(), dir.write("euroc_config.yaml", vins), "");
    CHECK_FALSE(mono.rig.has_right);
    check_radtan(mono.rig.left);
    CHECK((mono.rig.T_B_C0 * Eigen::Vector3d(0.1, 0.2, 1.0) - Eigen::Vector3d(1.05, -0.1, -0.2)).norm() < 1e-9);
    const std::string unplaced = dir.write("unplaced.yaml", replaced(vins, "extrinsicTranslation", "other"));
    CHECK(input_error_text([&] { load_calibration(dir.path(), unplaced, ""); }).find("without body_T_cam0") !=
          std::string::npos);
    std::string orb =
        "%YAML:1.0\nCamera.type: \"KannalaBrandt8\"\nCamera.width: 640\nCamera.height: 480\nCamera.bf: 19.3\n";
    for (const char* prefix : {"Camera.", "Camera2."}) {
        for (const char* field : {"fx: 400.0", "fy: 401.0", "cx: 319.0", "cy: 239.0", "k1: 0.003", "k2: 0.0007"}) {
            orb += std::string(prefix) + field + "\n";
        }
    }
    orb += "Tbc: " + opencv(kImuCam0) +
           "Tlr: !!opencv-matrix\n   rows: 3\n   cols: 4\n   dt: f\n   data: [1, 0, 0, 0.1, 0, 1, 0, 0, 0, 0, 1, 0]\n";
    check_rig(load_calibration(dir.path(), dir.write("TUM_512.yaml", orb), ""));
    const std::string lost = dir.write("lost.yaml", replaced(orb, "Tlr", "other"));
    CHECK(input_error_text([&] { load_calibration(dir.path(), lost, ""); }).find("Stereo.T_c1_c2: missing") !=
          std::string::npos);
}

TEST_CASE("OKVIS2: cameras with T_SC, and the IMU's figures without a rate") {
    const test::TempDir dir;
    const auto camera = [](const char* T) {
        return "  - {T_SC: " + std::string(T) +
               ", image_dimension: [640, 480], distortion_coefficients: [-0.28, 0.07, 0.0002, 0.00001], "
               "distortion_type: radialtangential, focal_length: [400, 401], principal_point: [319, 239]}\n";
    };
    const std::string text = "%YAML:1.0\ncameras:\n" + camera(kImuCam0) + camera(kImuCam1) +
                             "camera_parameters:\n  image_delay: 0.002\nimu_parameters:\n  use: true\n"
                             "  sigma_g_c: 0.005\n  sigma_a_c: 0.01\n  sigma_gw_c: 4.0e-06\n  sigma_aw_c: 0.0002\n";
    dir.write("imu0/data.csv", "1000000000,0,0,0,0,0,9.8\n1004000000,0,0,0,0,0,9.8\n");
    const Calibration c = load_calibration(dir.path(), dir.write("okvis.yaml", text), "");
    check_rig(c);
    check_radtan(c.rig.left);
    check_noise(c.noise);
    CHECK(c.camera_time_shift.ns == -2'000'000);
}

TEST_CASE("Kimera: a folder with a file for each sensor") {
    const test::TempDir dir;
    const auto camera = [](const char* T) {
        return "%YAML:1.0\ncamera_id: cam\nT_BS:\n  cols: 4\n  rows: 4\n  data: " + std::string(T) +
               "\nrate_hz: 20\nresolution: [640, 480]\ncamera_model: pinhole\nintrinsics: [400, 401, 319, 239]\n"
               "distortion_model: radial-tangential\ndistortion_coefficients: [-0.28, 0.07, 0.0002, 0.00001]\n";
    };
    dir.write("LeftCameraParams.yaml", camera(kImuCam0));
    dir.write("RightCameraParams.yaml", camera(kImuCam1));
    dir.write("ImuParams.yaml",
              "%YAML:1.0\nT_BS:\n  cols: 4\n  rows: 4\n"
              "  data: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\nrate_hz: 250\n"
              "gyroscope_noise_density: 0.005\ngyroscope_random_walk: 4.0e-06\n"
              "accelerometer_noise_density: 0.01\naccelerometer_random_walk: 0.0002\n"
              "n_gravity: [0.0, 0.0, -9.81]\n");
    const Calibration c = load_calibration(dir.path(), dir.path(), "");
    check_rig(c);
    check_noise(c.noise);
    CHECK(c.remarks == std::vector<std::string>{dir.file("ImuParams.yaml") + ":11: n_gravity: is not used"});
}

TEST_CASE("names what a file without a calibration of cameras against an IMU is and lacks") {
    const test::TempDir dir;
    const auto complaint = [&](const char* name, const std::string& text) {
        const std::string path = dir.write(name, text);
        return input_error_text([&] { load_calibration(dir.path(), path, ""); });
    };
    const auto says = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
    const std::string info =
        "image_width: 640\nimage_height: 480\ncamera_name: left\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
        "  data: [400, 0, 319, 0, 401, 239, 0, 0, 1]\ndistortion_model: plumb_bob\n";
    CHECK(says(complaint("left.yaml", info),
               "left.yaml:1: is the lens of one camera as ROS's camera_info has it: it "
               "does not say where the camera sits against the IMU"));
    CHECK(says(complaint("stereo.yaml", "M1: 1\nD1: 2\nR: 3\n"), "is a stereo calibration of OpenCV: it does not say"));
    CHECK(says(complaint("oak.json", "{\"cameraData\": []}"), "cameraData: none of the cameras is calibrated"));
    CHECK(says(complaint("imu.yaml", kNoise), "is the calibration of an IMU: give it as --imu-calibration"));
    CHECK(says(complaint("sensor.yaml", test::asl_camera_yaml(0)), "is a sensor.yaml of one camera: give the folder"));
    CHECK(says(complaint("params.yaml", "frontend:\n  a: 1\nwindow:\n  b: 2\n"),
               "is not a calibration of a known kind; it has frontend, window; known are those of Kalibr"));
    CHECK(says(complaint("empty.yaml", ""), "is not a calibration of a known kind; it has no key"));
    CHECK(says(complaint("camchain.yaml", replaced(chain(), "T_cam_imu", "T_none")),
               ":1: cam0: T_cam_imu: missing, or T_imu_cam: this camera chain does not say where the cameras sit"));
    const std::string basalt = dir.write("calib.json", kBasalt);
    Calibration vehicle;
    CHECK(says(input_error_text([&] { load_kalibr_cameras(basalt, vehicle); }),
               "is a calibration of Basalt: here it must be Kalibr's; facet calibration FILE --to kalibr"));
    const std::string path = dir.write("chain.yaml", chain());
    CHECK(says(input_error_text([&] { load_calibration(dir.path(), path, path); }),
               "is a camera chain of Kalibr or OpenVINS: give it as --calibration"));
}

TEST_CASE("a calibration that is given needs none in the log") {
    const test::TempDir dir;
    dir.write("log/imu0/data.csv", "1000000000,0,0,0,0,0,9.8\n1004000000,0,0,0,0,0,9.8\n");
    dir.write("log/cam1/data.csv", "");
    const std::string log = dir.file("log");
    CHECK(input_error_text([&] { load_calibration(log, "", ""); }).find("has no calibration") != std::string::npos);
    const std::string path = dir.write("chain.yaml", chain());
    const Calibration c = load_calibration(log, path, "");
    check_rig(c);
    CHECK(c.noise.rate_hz == Approx(250.0));
    CHECK(c.remarks.size() == 1);
    // The log's own IMU is taken where there is one, and the log's own cameras with an IMU that is given.
    dir.write("log/imu0/sensor.yaml", test::asl_imu_yaml());
    CHECK(load_calibration(log, path, "").noise.rate_hz == 200.0);
    std::filesystem::remove(dir.file("log/imu0/sensor.yaml"));
    dir.write("log/cam0/sensor.yaml", test::asl_camera_yaml(0));
    dir.write("log/cam1/sensor.yaml", test::asl_camera_yaml(1));
    check_noise(load_calibration(log, "", dir.write("imu.yaml", kNoise)).noise);
    // One camera for a log of two is told.
    const std::string alone = dir.write("alone.yaml", chain().substr(0, chain().find("cam1:")));
    const Calibration one = load_calibration(log, alone, dir.file("imu.yaml"));
    CHECK_FALSE(one.rig.has_right);
    CHECK(one.remarks == std::vector<std::string>{"the calibration has one camera, the log two: its cam1 is not used"});
}

TEST_CASE("a third camera and whatever else is not used is named") {
    const test::TempDir dir;
    const std::string text = chain() + "cam2:\n  resolution: [1, 1]\n";
    const std::string path = dir.write("chain.yaml", replaced(text, "rostopic: /cam", "line_delay: 1.0e-05"));
    const Calibration c = load_calibration(dir.path(), path, dir.write("imu.yaml", kNoise));
    CHECK(c.remarks ==
          std::vector<std::string>{path + ":17: cam2: is not used", path + ":8: cam0.line_delay: is not used"});
}

}  // namespace facet::other_programs_test
