// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/state_keeper.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "tests/support/synthetic_flight.h"
#include "tests/support/temp_dir.h"

namespace facet::state_keeper_test {
namespace {

Calibration calibration_of(double fx) {
    Calibration calibration;
    calibration.rig = test::make_rig();
    CameraIntrinsics k = calibration.rig.left.intrinsics();
    k.fx = fx;
    calibration.rig.left = CameraModel(k);
    return calibration;
}

KeptState some_state() {
    KeptState s;
    s.state.q_W_B = Eigen::AngleAxisd(0.3, Eigen::Vector3d(1.0, 2.0, -0.5).normalized());
    s.state.p_W_B = {1.0 / 3.0, -1e-7, 12345.678};
    s.state.v_W_B = {0.1, 0.2, 0.3};
    s.state.bias = {{1e-3, 2e-3, -3e-3}, {0.01, -0.02, 0.03}};
    s.sigma.setLinSpaced(1e-4, 1.0);
    s.calibration.correction.time_offset_s = -0.0123;
    s.calibration.correction.T_B_Bc.p = {1e-3, 2e-3, 3e-3};
    s.calibration.sigma.setLinSpaced(1e-6, 1e-2);
    return s;
}

TEST_CASE("a state of another lens or another model of the IMU does not count") {
    const test::TempDir dir;
    const Calibration given = calibration_of(400.0);
    StateKeeper keeper(dir.path(), given, "boot-1");
    REQUIRE(keeper.keep(some_state(), Timestamp{5'000'000'000}).empty());
    Calibration lens = given;
    CameraIntrinsics k = lens.rig.right.intrinsics();
    k.more[3] = 1e-6;
    lens.rig.right = CameraModel(k);
    Calibration imu = given;
    imu.imu_model = ImuModel(1.001 * Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Zero());
    for (const Calibration& other : {lens, imu}) {
        std::string refusal;
        CHECK_FALSE(StateKeeper(dir.path(), other, "boot-1").load(Timestamp{5'100'000'000}, refusal));
        CHECK(refusal.find("of another calibration") != std::string::npos);
    }
}

constexpr Timestamp kNow{5'000'000'000};

TEST_CASE("a state that is kept is found again, to the last bit but for the calibration's rounding") {
    const test::TempDir dir;
    const std::string folder = dir.file("new/state");
    std::string refusal;
    StateKeeper keeper(folder, calibration_of(400.0), "boot-1");
    CHECK_FALSE(keeper.load(kNow, refusal));
    CHECK(refusal.empty());  // there is none, which is no fault
    REQUIRE(keeper.keep(some_state(), kNow).empty());

    const auto found = StateKeeper(folder, calibration_of(400.0), "boot-1").load(kNow + Duration{500'000'000}, refusal);
    REQUIRE(found);
    CHECK(refusal.empty());
    CHECK(found->elapsed_s == Approx(0.5));
    const KeptState expected = some_state();
    CHECK(found->state.state.q_W_B.coeffs() == expected.state.q_W_B.coeffs());
    CHECK(found->state.state.p_W_B == expected.state.p_W_B);
    CHECK(found->state.state.v_W_B == expected.state.v_W_B);
    CHECK(found->state.state.bias.gyro == expected.state.bias.gyro);
    CHECK(found->state.state.bias.accel == expected.state.bias.accel);
    CHECK(found->state.sigma == expected.sigma);
    CHECK(found->state.calibration.sigma == expected.calibration.sigma);
    CHECK(expected.calibration.correction.box_minus_to(found->state.calibration.correction).norm() < 1e-15);

    keeper.forget();
    CHECK_FALSE(keeper.load(kNow, refusal));
    CHECK(refusal.empty());
}

TEST_CASE("a state of another time, boot or calibration is not used, and it is said why") {
    const test::TempDir dir;
    REQUIRE(StateKeeper(dir.path(), calibration_of(400.0), "boot-1").keep(some_state(), kNow).empty());
    std::string refusal;
    CHECK_FALSE(StateKeeper(dir.path(), calibration_of(400.0), "boot-2").load(kNow, refusal));
    CHECK(refusal.find("another boot") != std::string::npos);
    CHECK_FALSE(StateKeeper(dir.path(), calibration_of(400.0), "").load(kNow, refusal));
    CHECK(refusal.find("another boot") != std::string::npos);
    CHECK_FALSE(StateKeeper(dir.path(), calibration_of(401.0), "boot-1").load(kNow, refusal));
    CHECK(refusal.find("another calibration") != std::string::npos);
    const StateKeeper same(dir.path(), calibration_of(400.0), "boot-1");
    CHECK_FALSE(same.load(kNow + Duration::from_seconds(61.0), refusal));
    CHECK(refusal.find("60 s") != std::string::npos);
    CHECK_FALSE(same.load(kNow + Duration{-1}, refusal));
    CHECK(refusal.find("60 s") != std::string::npos);
    CHECK(same.load(kNow + Duration::from_seconds(59.0), refusal));
}

TEST_CASE("rejects a state cut anywhere, or with a word that is not a number") {
    const test::TempDir dir;
    const StateKeeper keeper(dir.path(), calibration_of(400.0), "boot-1");
    REQUIRE(StateKeeper(keeper).keep(some_state(), kNow).empty());
    const std::string path = dir.file("last_state");
    const std::string whole = test::read_file(path);
    std::string refusal;
    for (std::size_t length = 0; length + 5 < whole.size(); length += 7) {
        std::ofstream(path) << whole.substr(0, length);
        CAPTURE(length);
        CHECK_FALSE(keeper.load(kNow, refusal));
        CHECK_FALSE(refusal.empty());
    }
    std::string wrong = whole;
    wrong.replace(wrong.find("bias_gyro ") + 10, 1, "x");
    std::ofstream(path) << wrong;
    CHECK_FALSE(keeper.load(kNow, refusal));
}

TEST_CASE("a run knows whether the one before it was broken off, on this boot") {
    const test::TempDir dir;
    const std::string folder = dir.file("runtime");
    StateKeeper first(folder, calibration_of(400.0), "boot-1");
    CHECK_FALSE(first.is_in_flight());
    REQUIRE(first.keep(some_state(), kNow).empty());
    const StateKeeper second(folder, calibration_of(401.0), "boot-1");  // the first one was killed
    CHECK(second.is_in_flight());
    std::string refusal;
    CHECK_FALSE(second.load(kNow + Duration::from_seconds(600.0), refusal));
    CHECK(second.is_in_flight());  // the second one, too, before it had a state
    CHECK_FALSE(StateKeeper(folder, calibration_of(400.0), "boot-2").is_in_flight());
    CHECK_FALSE(StateKeeper("", calibration_of(400.0), "boot-1").is_in_flight());
    second.forget();
    CHECK_FALSE(second.is_in_flight());
    std::ofstream(folder + "/last_state") << "facet_state_1\nboot ";
    CHECK_FALSE(second.is_in_flight());
}

TEST_CASE("reports a folder that cannot be written once; no folder is not an error") {
    const test::TempDir dir;
    std::ofstream(dir.file("file")) << "in the way";
    StateKeeper blocked(dir.file("file") + "/state", calibration_of(400.0), "boot-1");
    CHECK_FALSE(blocked.keep(some_state(), kNow).empty());
    CHECK(blocked.keep(some_state(), kNow).empty());
    StateKeeper none("", calibration_of(400.0), "boot-1");
    CHECK(none.keep(some_state(), kNow).empty());
    std::string refusal;
    CHECK_FALSE(none.load(kNow, refusal));
    CHECK_FALSE(boot_id().empty());
}

}  // namespace
}  // namespace facet::state_keeper_test
