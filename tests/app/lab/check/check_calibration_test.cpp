// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/check/check_calibration.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/support/asl_folder.h"
#include "tests/support/input_error_text.h"
#include "tests/support/temp_dir.h"

namespace facet::check_calibration_test {
namespace {

const CheckVerdict& named(const std::vector<CheckVerdict>& verdicts, const std::string& name) {
    const auto found = std::ranges::find(verdicts, name, &CheckVerdict::name);
    REQUIRE(found != verdicts.end());
    return *found;
}

TEST_CASE("a log of a vehicle at rest: gravity is seen, cameras and gyroscope cannot be compared") {
    const test::TempDir dir;
    test::write_asl_folder(dir, 40);
    CheckOptions options;
    options.dataset = dir.path();
    options.calibration = load_euroc_calibration(dir.file("mav0"));
    const std::vector<CheckVerdict> verdicts = check_calibration(options);
    CHECK(named(verdicts, "gravity").level == CheckLevel::kOk);
    CHECK(named(verdicts, "imu rate").level == CheckLevel::kOk);
    CHECK(named(verdicts, "imu axes").level == CheckLevel::kCannotTell);
    CHECK(named(verdicts, "two images").level == CheckLevel::kOk);

    write_verdicts(verdicts, dir.file("verdicts.json"));
    const auto json = nlohmann::json::parse(test::read_file(dir.file("verdicts.json")));
    REQUIRE(json.at("checks").size() == verdicts.size());
    CHECK(json.at("checks").at(0).at("check") == "imu rate");
    CHECK(json.at("checks").at(0).at("verdict") == "ok");
    CHECK(json.at("checks").at(0).at("figures").at("rate_hz") == Approx(200.0));
}

TEST_CASE("only wrong verdicts are wrong") {
    std::vector<CheckVerdict> verdicts(3);
    verdicts[1].level = CheckLevel::kSuspicious;
    CHECK_FALSE(has_wrong(verdicts));
    verdicts[2].level = CheckLevel::kWrong;
    CHECK(has_wrong(verdicts));
}

TEST_CASE("a folder without a log is bad input") {
    const test::TempDir dir;
    CheckOptions options;
    options.dataset = dir.path();
    CHECK(test::input_error_text([&] { check_calibration(options); }).find(dir.path()) != std::string::npos);
}

TEST_CASE("a calibration of other images is wrong, one camera is checked against the IMU alone") {
    const test::TempDir dir;
    test::write_asl_folder(dir, 40);
    CheckOptions options;
    options.dataset = dir.path();
    options.calibration = load_euroc_calibration(dir.file("mav0"));
    CameraIntrinsics k = options.calibration.rig.left.intrinsics();
    k.width = 200;
    options.calibration.rig.left = CameraModel(k);
    const std::vector<CheckVerdict> verdicts = check_calibration(options);
    CHECK(named(verdicts, "image size").level == CheckLevel::kWrong);
    CHECK(has_wrong(verdicts));

    options.calibration = load_euroc_calibration(dir.file("mav0"));
    options.calibration.rig = StereoRig::monocular(options.calibration.rig.left, options.calibration.rig.T_B_C0);
    const std::vector<CheckVerdict> alone = check_calibration(options);
    CHECK_FALSE(has_wrong(alone));
    CHECK(named(alone, "time offset").level == CheckLevel::kCannotTell);
    CHECK(std::ranges::find(alone, "two images", &CheckVerdict::name) == alone.end());
}

}  // namespace
}  // namespace facet::check_calibration_test
