// SPDX-License-Identifier: BSD-2-Clause
// What RealSense's and OAK's own tools write of a camera's calibration.
#include <catch2/catch.hpp>

#include "app/calibration/calibration.h"
#include "app/calibration/calibration_writer.h"
#include "tests/support/input_error_text.h"
#include "tests/support/temp_dir.h"

namespace facet::camera_exports_test {
namespace {

using test::input_error_text;

bool says(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// All of them replaced.
std::string with(std::string text, const std::string& from, const std::string& to) {
    std::size_t count = 0;
    for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
        text.replace(at, from.size(), to);
        ++count;
    }
    REQUIRE(count > 0);
    return text;
}

std::string listed_lens(const std::string& head, const char* width, const char* height, const char* f,
                        const std::string& lens = "Brown Conrady\n  Coeffs:     \t0  \t0  \t0  \t0  \t0") {
    return " Intrinsic of " + head + "\n  Width:      \t" + width + "\n  Height:     \t" + height +
           "\n  PPX:        \t319.5\n  PPY:        \t240.25\n  Fx:         \t" + f + "\n  Fy:         \t" + f +
           "\n  Distortion: \t" + lens + "\n  FOV (deg): \t79.8 x 64.2\n\n";
}

std::string listed_transform(const std::string& from, const std::string& to, const std::string& translation,
                             const std::string& rotation =
                                 "   1             0             0  \n"
                                 "   0             1             0  \n"
                                 "   0             0             1  \n") {
    return "Extrinsic from \"" + from + "\"\t  To\t  \"" + to + "\" :\n Rotation Matrix:\n" + rotation +
           "\n Translation Vector: " + translation + "  \n\n";
}

/// A D435i: its IMU is turned by half a turn about z here, which real ones are not, so that a transposed or inverted
/// matrix would show.
std::string listing() {
    return "Device info: \n    Name                          : \tIntel RealSense D435I\n\n"
           "Stream Profiles supported by Stereo Module\n Supported modes:\n"
           "    Infrared 1     640x480\t@ 30Hz\t   Y8\n\nIntrinsic Parameters:\n\n" +
           listed_lens("\"Color\" / 640x480 / {YUYV/RGB8}", "640", "480", "600.5",
                       "Inverse Brown Conrady\n  Coeffs:     \t-0.05  \t0.06  \t0  \t0  \t-0.02") +
           listed_lens("\"Infrared 1\" / 640x480 / {Y8}", "640", "480", "381.5") +
           listed_lens("\"Infrared 1\" / 640x480 / {Y16}", "640", "480", "390.5") +
           listed_lens("\"Infrared 1\" / 848x480 / {Y8}", "848", "480", "420.5") +
           listed_lens("\"Infrared 2\" / 640x480 / {Y8}", "640", "480", "382.5") +
           listed_lens("\"Infrared 2\" / 848x480 / {Y8}", "848", "480", "421.5") +
           "Motion Intrinsic Parameters:\n\nMotion Intrinsic of \"Gyro\"\t  MOTION_XYZ32F\n"
           "Bias Variances: \t0  0  0  \nNoise Variances: \t0  0  0  \nSensitivity : \n"
           "     1.000000       0.000000       0.000000       0.000000  \n"
           "     0.000000       1.000000       0.000000       0.000000  \n"
           "     0.000000       0.000000       1.000000       0.000000  \n\n\n"
           "Extrinsic Parameters:\n" +
           listed_transform("Infrared 1", "Infrared 1", "0  0  0") +
           listed_transform("Infrared 1", "Infrared 2", "-0.0499  0  0") +
           listed_transform("Infrared 1", "Gyro", "-0.0055  0.0051  0.0117",
                            "  -1             0             0  \n   0            -1             0  \n"
                            "   0             0             1  \n") +
           "Extrinsic from \"Color\"\t  To\t  \"Gyro\" :\nN/A\n";
}

Calibration load(const test::TempDir& dir, const std::string& text, const ImageExtent& images) {
    return load_calibration(dir.path(), dir.write("calibration.txt", text), "", images);
}

void check_d435i(const Calibration& c) {
    CHECK(c.rig.has_right);
    CHECK(c.rig.left.intrinsics().fx == 381.5);
    CHECK(c.rig.right.intrinsics().fy == 382.5);
    CHECK(c.rig.left.intrinsics().cx == 319.5);
    CHECK(c.rig.left.intrinsics().cy == 240.25);
    CHECK(c.rig.left.intrinsics().width == 640);
    // p_gyro = R p_ir1 + t.
    CHECK((c.rig.T_B_C0 * Eigen::Vector3d(1.0, 2.0, 3.0) - Eigen::Vector3d(-1.0055, -1.9949, 3.0117)).norm() < 1e-9);
    // The right camera stands to the right of the left one.
    CHECK((c.rig.T_C1_C0().p - Eigen::Vector3d(-0.0499, 0.0, 0.0)).norm() < 1e-9);
}

std::string oak_camera(
    int socket, int to, const char* translation, const char* f,
    const char* coefficients = "[4.5, -2.0, 0.001, -0.002, 0.5, 4.0, -1.5, 0.25, 0, 0, 0, 0, 0, 0]") {
    return "[" + std::to_string(socket) + ", {\"cameraType\": 0, \"distortionCoeff\": " + coefficients +
           ", \"extrinsics\": {\"rotationMatrix\": " + (to < 0 ? "[]" : "[[1,0,0],[0,1,0],[0,0,1]]") +
           ", \"specTranslation\": {\"x\": 0.0, \"y\": 0.0, \"z\": 0.0}, \"toCameraSocket\": " + std::to_string(to) +
           ", \"translation\": " + translation + "}, \"height\": 800, \"intrinsicMatrix\": [[" + f +
           ", 0.0, 640.5], [0.0, " + f +
           ", 400.5], [0.0, 0.0, 1.0]], \"lensPosition\": 0, \"specHfovDeg\": 71.8, \"width\": 1280}]";
}

/// The IMU's axes on the colour camera, socket 0: x_C = -y_B, y_C = -z_B, z_C = x_B, and 1 cm, 2 cm, 3 cm.
std::string oak() {
    return "{\n    \"batchName\": \"\",\n    \"boardName\": \"OAK-D\",\n    \"cameraData\": [\n        " +
           oak_camera(2, 0, "{\"x\": 3.75, \"y\": 0.0, \"z\": 0.0}", "801") + ",\n        " +
           oak_camera(1, 2, "{\"x\": -7.5, \"y\": 0.0, \"z\": 0.0}", "800") + ",\n        " +
           oak_camera(0, -1, "{\"x\": 0.0, \"y\": 0.0, \"z\": 0.0}", "1000") +
           "\n    ],\n    \"imuExtrinsics\": {\"rotationMatrix\": [[0,-1,0],[0,0,-1],[1,0,0]], \"specTranslation\": "
           "{\"x\": 1.0, \"y\": 2.0, \"z\": 3.0}, \"toCameraSocket\": 0, \"translation\": {\"x\": 1.0, \"y\": 2.0, "
           "\"z\": 3.0}},\n    \"stereoRectificationData\": {\"leftCameraSocket\": 1, \"rightCameraSocket\": 2},\n"
           "    \"version\": 7\n}\n";
}

}  // namespace

TEST_CASE("RealSense: the infrared pair against the gyroscope, at the images' resolution") {
    const test::TempDir dir;
    const Calibration c = load(dir, listing(), {640, 480});
    check_d435i(c);
    // Nothing but the IMU's noise is missing.
    REQUIRE(c.remarks.size() == 1);
    CHECK(says(c.remarks[0], "no file says how noisy the IMU is"));
    CHECK(load(dir, listing(), {848, 480}).rig.right.intrinsics().fx == 421.5);
    const std::string text = input_error_text([&] { load(dir, listing(), {1280, 720}); });
    CHECK(says(text,
               "calibration.txt:21: Intrinsic of \"Infrared 1\": the images have 1280x720 px, which is none of "
               "its resolutions: 640x480, 848x480"));
    CHECK(says(input_error_text([&] { load(dir, listing(), {}); }), "facet calibration FILE --image-size 640x480"));
}

TEST_CASE("RealSense: saved by PowerShell, with CRLF, in the words of older releases") {
    const test::TempDir dir;
    std::string wide = "\xFF\xFE";
    for (const char c : with(listing(), "\n", "\r\n")) {
        wide += c;
        wide += '\0';
    }
    check_d435i(load(dir, wide, {640, 480}));
    std::string old = with(listing(), "\" / 640x480 / {Y8}", "\"\t  640x480\t  {Y8}");
    old = with(old, "\" / 640x480 / {Y16}", "\"\t  640x480\t  {Y16}");
    check_d435i(load(dir, "\xEF\xBB\xBF" + old, {640, 480}));
}

TEST_CASE("RealSense: other streams, lenses and devices") {
    const test::TempDir dir;
    const auto t265 = [](const std::string& lens) {
        return "Intrinsic Parameters:\n\n" +
               listed_lens("\"Fisheye 1\" / 848x800 / {Y8}", "848", "800", "286.5", lens) +
               listed_lens("\"Fisheye 2\" / 848x800 / {Y8}", "848", "800", "286.5", lens) +
               listed_transform("Fisheye 2", "Fisheye 1", "0.064  0  0") +
               listed_transform("Gyro", "Fisheye 1", "0.01  0  0");
    };
    const Calibration c =
        load(dir, t265("Kannala Brandt4\n  Coeffs:     \t-0.0043  \t0.0371  \t-0.0355  \t0.0057  \t0"), {});
    CHECK(c.rig.left.intrinsics().distortion == Distortion::kEquidistant);
    CHECK(c.rig.left.intrinsics().coeffs == std::array{-0.0043, 0.0371, -0.0355, 0.0057});
    CHECK((c.rig.T_B_C0.p - Eigen::Vector3d(-0.01, 0.0, 0.0)).norm() < 1e-9);
    CHECK((c.rig.T_B_C1.p - Eigen::Vector3d(0.054, 0.0, 0.0)).norm() < 1e-9);
    CHECK(load(dir, t265("F-Theta\n  Coeffs:     \t0.93  \t0  \t0  \t0  \t0"), {}).rig.left.intrinsics().distortion ==
          Distortion::kFov);
    const auto lens_of = [&](const char* lens) { return load(dir, t265(lens), {}).rig.left.intrinsics(); };
    CHECK(lens_of("Brown Conrady\n  Coeffs:     \t-0.02  \t0.005  \t0.0001  \t0.0002  \t-0.0004").more[0] == -0.0004);
    CHECK(lens_of("None\n  Coeffs:     \t0  \t0  \t0  \t0  \t0").distortion == Distortion::kNone);
    CHECK(lens_of("Inverse Brown Conrady\n  Coeffs: \t0  \t0  \t0  \t0  \t0").coeffs == std::array<double, 4>{});
    const auto complaint = [&](const char* lens) { return input_error_text([&] { load(dir, t265(lens), {}); }); };
    CHECK(says(complaint("Modified Brown Conrady\n  Coeffs:  0.1  0.1  0.001  0  0"), "with tangential coefficients"));
    CHECK(says(complaint("Inverse Brown Conrady\n  Coeffs:  0.1  0.1  0.001  0  0"), "from distorted to undistorted"));
    CHECK(says(complaint("Pillow\n  Coeffs:  0.1  0.1  0.001  0  0"), "unknown distortion 'Pillow'"));
    // Color alone.
    const std::string color = with(with(listing(), "Infrared", "Depth"), "Inverse ", "");
    const std::string placed = with(color, "Extrinsic from \"Color\"\t  To\t  \"Gyro\" :\nN/A\n",
                                    listed_transform("Color", "Accel", "0.01  0  0"));
    const Calibration one = load(dir, placed, {});
    CHECK_FALSE(one.rig.has_right);
    CHECK(one.rig.left.intrinsics().fx == 600.5);
    CHECK(one.rig.T_B_C0.p.x() == 0.01);
    CHECK(says(input_error_text([&] { load(dir, color, {}); }), "has no extrinsic from \"Color\" to \"Gyro\""));
    const Calibration two = load(dir, with(listing(), "1.000000", "1.010000") + listing(), {640, 480});
    check_d435i(two);
    CHECK(says(two.remarks[0], "lists several cameras, of which the first one is used"));
    CHECK(says(two.remarks[1], "motion intrinsics are not used"));
}

TEST_CASE("RealSense: files without a calibration say which command writes one") {
    const test::TempDir dir;
    const auto complaint = [&](const std::string& text) {
        return input_error_text([&] { load(dir, text, {640, 480}); });
    };
    const std::string what = "rs-enumerate-devices -c > FILE writes";
    CHECK(says(complaint(listing().substr(0, listing().find("Intrinsic Parameters"))), what));
    CHECK(says(complaint("{\"imus\": [{\"accelerometer\": {}}], \"cameras\": []}"),
               "is the calibration of a RealSense's IMU: it has no cameras; " + what));
    CHECK(says(complaint("{\"device\": {}, \"parameters\": {}, \"schema version\": 1, \"viewer\": {}}"),
               "is a preset of realsense-viewer: it has no cameras; " + what));
    const std::string path = dir.write("rs.txt", listing());
    CHECK(says(input_error_text([&] {
                   load_calibration(dir.path(), path, path, {640, 480});
               }),
               "is the calibration of a RealSense camera: give it as --calibration"));
    CHECK(says(complaint(with(listing(), "0.0051  0.0117", "")), "is not a rotation matrix with a translation vector"));
    CHECK(says(complaint(with(listing(), "  Fx:         \t381.5\n", "")), "\"Infrared 1\": Fx: is missing"));
}

TEST_CASE("OAK: chains of extrinsics in centimetres, and OpenCV's rational lens") {
    const test::TempDir dir;
    const auto load_oak = [&](const std::string& text, const ImageExtent& images) {
        return load_calibration(dir.path(), dir.write("calib.json", text), "", images);
    };
    const Calibration c = load_oak(oak(), {});
    const CameraIntrinsics& k = c.rig.left.intrinsics();
    CHECK(c.rig.has_right);
    CHECK(k.fx == 800.0);
    CHECK(c.rig.right.intrinsics().fx == 801.0);
    CHECK(k.distortion == Distortion::kRational);
    CHECK(k.coeffs == std::array{4.5, -2.0, 0.001, -0.002});
    CHECK(k.more == std::array{0.5, 4.0, -1.5, 0.25});
    // A point 1 m ahead of the IMU is ahead of the colour camera: (1, 2, 103) cm there, and 3.75 cm farther to the
    // right in the left camera, which is that much to the left.
    CHECK((c.rig.T_B_C0.inverse() * Eigen::Vector3d(1.0, 0.0, 0.0) - Eigen::Vector3d(0.0475, 0.02, 1.03)).norm() <
          1e-9);
    CHECK((c.rig.T_B_C1.inverse() * Eigen::Vector3d(1.0, 0.0, 0.0) - Eigen::Vector3d(-0.0275, 0.02, 1.03)).norm() <
          1e-9);
    REQUIRE(c.remarks.size() == 2);
    CHECK(says(c.remarks[0], "cameraData.2.1: the camera of socket 0 is not used"));
    CHECK(says(c.remarks[1], "no file says how noisy the IMU is"));
    // Metres, and translations that are known from the drawing only.
    const Calibration metres = load_oak(with(oak(), "\"toCameraSocket\"", "\"lengthUnit\": 0, \"toCameraSocket\""), {});
    CHECK(metres.rig.baseline_m() == Approx(7.5));
    const Calibration drawn = load_oak(
        with(oak(), "\"translation\": {\"x\": 1.0, \"y\": 2.0, ", "\"translation\": {\"x\": 0, \"y\": 0, "), {});
    CHECK((drawn.rig.T_B_C0.p - c.rig.T_B_C0.p).norm() > 0.01);  // z alone: not zero, so it counts
    const Calibration spec = load_oak(with(oak(), "\"translation\": {\"x\": 1.0, \"y\": 2.0, \"z\": 3.0}",
                                           "\"translation\": {\"x\": 0, \"y\": 0, \"z\": 0}"),
                                      {});
    CHECK((spec.rig.T_B_C0.p - c.rig.T_B_C0.p).norm() < 1e-12);
    CHECK(says(spec.remarks[0], "imuExtrinsics: translation is zero, specTranslation is used instead"));
    // All of it again from what is written of it.
    write_kalibr_files(c, dir.file("kalibr"));
    const Calibration again = load_calibration(dir.path(), dir.file("kalibr/camchain-imucam.yaml"), "");
    CHECK((again.rig.T_B_C1.p - c.rig.T_B_C1.p).norm() < 1e-9);
    CHECK(again.rig.right.intrinsics().more == k.more);
}

TEST_CASE("OAK: images of another size than the calibration's") {
    const test::TempDir dir;
    const std::string path = dir.write("calib.json", oak());
    const CameraIntrinsics half = load_calibration(dir.path(), path, "", {640, 400}).rig.left.intrinsics();
    CHECK(half.width == 640);
    CHECK(half.height == 400);
    CHECK(half.fx == 400.0);
    CHECK(half.cx == 320.0);  // 641 columns to the left of it, the half of its own among them: 320.5 of twice the size
    CHECK(half.cy == 200.0);
    const Calibration cropped = load_calibration(dir.path(), path, "", {1280, 720});
    CHECK(cropped.rig.left.intrinsics().fx == 800.0);
    CHECK(cropped.rig.left.intrinsics().cx == 640.5);
    CHECK(cropped.rig.left.intrinsics().cy == 360.5);  // 40 rows less above
    CHECK(says(cropped.remarks[0], "is for images of 1280x800 px, scaled to 1280x720"));
}

TEST_CASE("OAK: what a file lacks, and lenses that are none here") {
    const test::TempDir dir;
    const auto load_oak = [&](const std::string& text) {
        return load_calibration(dir.path(), dir.write("calib.json", text), "");
    };
    const auto complaint = [&](const std::string& text) { return input_error_text([&] { load_oak(text); }); };
    const std::string empty = "is empty: this camera's calibration does not say where the IMU sits";
    CHECK(says(complaint(with(oak(), "[[0,-1,0],[0,0,-1],[1,0,0]]", "[[0,0,0],[0,0,0],[0,0,0]]")), empty));
    CHECK(says(complaint(with(oak(), "[[0,-1,0],[0,0,-1],[1,0,0]]", "[]")), empty));
    CHECK(says(complaint(with(oak(), "imuExtrinsics", "housingExtrinsics")), empty));
    CHECK(says(complaint(with(oak(), "0, 0, 0, 0, 0, 0]", "0, 0, 0, 0, 0.01, 0]")),
               "distortionCoeff: a thin prism or a tilted sensor, coefficients 9 and on, is not modelled"));
    CHECK(says(complaint(with(oak(), "\"cameraType\": 0", "\"cameraType\": 2")), "cameraType: is 2: only 0"));
    CHECK(says(complaint(with(oak(), "\"toCameraSocket\": 2", "\"toCameraSocket\": 5")),
               "cameraData: no extrinsics lead from socket 0 to socket 1"));
    CHECK(says(complaint(with(oak(), "\"x\": -7.5", "\"x\": -7500")), "baseline between the cameras is 75 m"));
    const Calibration fisheye =
        load_oak(with(oak(), "\"cameraType\": 0, \"distortionCoeff\": [4.5, -2.0, 0.001, -0.002",
                      "\"cameraType\": 1, \"distortionCoeff\": [0.01, 0.02, 0.003, 0.004"));
    CHECK(fisheye.rig.left.intrinsics().distortion == Distortion::kEquidistant);
    CHECK(fisheye.rig.left.intrinsics().coeffs == std::array{0.01, 0.02, 0.003, 0.004});
    // Left and right exchanged in the file; one camera with nothing of the others.
    const Calibration exchanged = load_oak(with(oak(), "\"leftCameraSocket\": 1, \"rightCameraSocket\": 2",
                                                "\"leftCameraSocket\": 2, \"rightCameraSocket\": 1"));
    CHECK(exchanged.rig.left.intrinsics().fx == 801.0);
    CHECK(says(exchanged.remarks[0], "the camera of socket 2, called left, is to the right of socket 1"));
    const Calibration one = load_oak(with(with(oak(), "[[800, 0.0", "[[0.0, 0.0"), "[[801, 0.0", "[[0.0, 0.0"));
    CHECK_FALSE(one.rig.has_right);
    CHECK(one.rig.left.intrinsics().fx == 1000.0);
}

}  // namespace facet::camera_exports_test
