// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/calibrate/calibration_files.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "app/lab/calibrate/residual_picture.h"
#include "app/lab/sim/default_rig.h"
#include "drivers/replay_asl/png_decoder.h"
#include "tests/support/temp_dir.h"

namespace facet::calibration_files_test {
namespace {

RefinedCalibration some_calibration(Distortion distortion) {
    RefinedCalibration c;
    c.refined.rig = sim::euroc_rig();
    if (distortion != Distortion::kRadialTangential) {
        CameraIntrinsics k = c.refined.rig.left.intrinsics();
        k.distortion = distortion;
        k.coeffs = distortion == Distortion::kNone ? std::array<double, 4>{} : std::array{-0.01, 0.02, -0.003, 0.001};
        c.refined.rig.left = CameraModel(k);
    }
    c.refined.time_shift_s = -0.00321;
    c.noise = sim::euroc_imu_noise();
    c.sigma = good_sigmas(c.refined.rig);
    return c;
}

void check_same(const Calibration& read, const RefinedCalibration& written) {
    const auto check_camera = [](const CameraIntrinsics& a, const CameraIntrinsics& b) {
        CHECK(a.fx == Approx(b.fx).epsilon(1e-11));
        CHECK(a.cy == Approx(b.cy).epsilon(1e-11));
        CHECK(a.width == b.width);
        CHECK(a.distortion == b.distortion);
        for (std::size_t i = 0; i < 4; ++i) {
            CHECK(a.coeffs[i] == Approx(b.coeffs[i]).epsilon(1e-11));
        }
    };
    const StereoRig& rig = written.refined.rig;
    check_camera(read.rig.left.intrinsics(), rig.left.intrinsics());
    check_camera(read.rig.right.intrinsics(), rig.right.intrinsics());
    CHECK(read.rig.T_B_C0.box_minus_to(rig.T_B_C0).norm() < 1e-10);
    CHECK(read.rig.T_B_C1.box_minus_to(rig.T_B_C1).norm() < 1e-10);
    CHECK(read.camera_time_shift.seconds() == Approx(written.refined.time_shift_s).margin(1e-9));
    CHECK(read.noise.accel_walk_m_per_s3_per_sqrt_hz == Approx(written.noise.accel_walk_m_per_s3_per_sqrt_hz));
    CHECK(read.noise.rate_hz == written.noise.rate_hz);
}

TEST_CASE("what is written is read back, from EuRoC's files and from Kalibr's") {
    for (const Distortion distortion : {Distortion::kNone, Distortion::kRadialTangential, Distortion::kEquidistant}) {
        const test::TempDir dir;
        const RefinedCalibration written = some_calibration(distortion);
        write_calibration(written, dir.path());
        check_same(load_euroc_calibration(dir.path()), written);
        check_same(load_calibration("unused", dir.path(), ""), written);
        const std::string chain = dir.file("camchain-imucam.yaml");
        check_same(load_kalibr_calibration(chain, dir.file("imu.yaml")), written);
        check_same(load_calibration("unused", chain, dir.file("imu.yaml")), written);
    }
}

TEST_CASE("standard deviations stand beside the values, in pixels and degrees") {
    const test::TempDir dir;
    write_calibration(some_calibration(Distortion::kRadialTangential), dir.path());
    const std::string text = test::read_file(dir.file("cam0/sensor.yaml"));
    CHECK(text.find("intrinsics_sigma: [0.229, 0.229, 0.3, 0.3]") != std::string::npos);
    CHECK(text.find("distortion_sigma: [0.0005, 0.0005, 0.0001, 0.0001]") != std::string::npos);
    CHECK(text.find("rotation_sigma_deg: [0.0298, 0.0298, 0.0298]") != std::string::npos);
}

TEST_CASE("the account has every parameter with its verdict, and advice where it is not found") {
    const test::TempDir dir;
    const RigAndTime given{sim::euroc_rig(), 0.001};
    const RigVector prior = prior_sigmas(given.rig, 1.0);
    RigVector sigma = good_sigmas(given.rig);
    sigma(kBatchTime) = prior(kBatchTime);
    RigVector correction = RigVector::Zero();
    correction(0) = 1e-3;
    BatchResult result;
    result.before = {{0, {10.0, 10.0}, {3.0, 4.0}}};
    const CalibrationAccount account{"log", "sensor.yaml", 20.0, describe_parameters(given, correction, sigma, prior)};
    write_calibration_json(account, result, dir.path());
    const auto json = nlohmann::json::parse(test::read_file(dir.file("calibration.json")));
    REQUIRE(json.at("parameters").size() == kBatchDim);
    const auto& fx = json.at("parameters").at(0);
    CHECK(fx.at("name") == "cam0.fx");
    CHECK(fx.at("given") == Approx(458.654));
    CHECK(fx.at("refined") == Approx(458.654 * 1.001));
    CHECK(fx.at("sigma") == Approx(458.654 * 5e-4));
    CHECK(fx.at("verdict") == "found");
    CHECK_FALSE(fx.contains("advice"));
    const auto& shift = json.at("parameters").back();
    CHECK(shift.at("name") == "time_shift");
    CHECK(shift.at("given") == Approx(1.0));
    CHECK(shift.at("verdict") == "not observable: kept as given");
    CHECK(shift.at("advice") == "turn faster");
    CHECK(json.at("residuals").at("before").at("cam0").at("rms_px") == Approx(5.0 / std::sqrt(2.0)));
}

TEST_CASE("coefficients that a lens does not have are no parameters") {
    StereoRig rig = sim::euroc_rig();
    CameraIntrinsics k = rig.left.intrinsics();
    k.distortion = Distortion::kNone;
    k.coeffs = {};
    rig.left = CameraModel(k);
    const RigVector prior = prior_sigmas(rig, 1.0);
    CHECK(describe_parameters({rig, 0.0}, RigVector::Zero(), prior, prior).size() == kBatchDim - 4);
}

TEST_CASE("verdicts follow from the standard deviations") {
    CHECK(judge_parameter(0.2, 3.0, 0.3) == ParameterVerdict::kFound);
    CHECK(judge_parameter(0.9, 3.0, 0.3) == ParameterVerdict::kWeak);
    CHECK(judge_parameter(2.5, 3.0, 0.3) == ParameterVerdict::kNotObservable);
}

TEST_CASE("a residual picture has grey lines and a black mean") {
    const test::TempDir dir;
    const CameraIntrinsics size = sim::euroc_rig().left.intrinsics();
    std::vector<SightingResidual> residuals;
    for (int i = 0; i < 20; ++i) {
        residuals.push_back({0, {100.0 + i, 100.0}, {0.0, 0.1}});
        residuals.push_back({1, {500.0, 300.0}, {0.0, 1.0}});
    }
    write_residual_picture(dir.file("a.png"), size, residuals, 0);
    PngDecoder decoder;
    GreyImage image;
    REQUIRE(ok(decoder.decode(dir.file("a.png"), size.width, size.height, image)));
    CHECK(image.view().at(105, 101) < 255);   // single residuals, 10 times: 1 px down
    CHECK(image.view().at(100, 105) == 0);    // mean of its cell from (100, 100), 100 times: 10 px down
    CHECK(image.view().at(500, 300) == 255);  // the other camera's
}

}  // namespace
}  // namespace facet::calibration_files_test
