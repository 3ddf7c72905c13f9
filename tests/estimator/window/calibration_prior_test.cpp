// SPDX-License-Identifier: BSD-2-Clause
// The prior of the calibration, and what a window that begins anew keeps of it.
#include "estimator/window/calibration_prior.h"

#include <catch2/catch.hpp>
#include <memory>
#include <random>

#include "estimator/imu/propagation.h"
#include "estimator/window/window.h"
#include "tests/support/synthetic_flight.h"

namespace facet::calibration_prior_test {

using facet::test::SyntheticFlight;

namespace {

/// Flies, five keyframes a second; `wrong` is what the readings are off by, to first order.
std::unique_ptr<Window> flown(const CalibrationConfig& calibration, SyntheticFlight& flight, int keyframes,
                              const ImuScale& wrong = {}) {
    const ImuNoise noise = test::euroc_like_noise();
    WindowConfig config;
    config.keyframes = 12;
    config.pixel_sigma_px = 0.2;
    auto window = std::make_unique<Window>();
    window->configure(config, calibration, flight.rig(), noise);
    const StateCovariance information = test::start_sigmas().cwiseAbs2().cwiseInverse().asDiagonal();
    for (int k = 0; k <= keyframes; ++k) {
        const double t = 0.2 * k;
        const auto seen = flight.observe(t);
        const KeyframeInput input{test::at(t), flight.rate(t), false, {seen.data(), seen.size()}};
        if (k == 0) {
            window->start(input, flight.state(t), information);
            continue;
        }
        Preintegration p(window->newest().state.bias);
        p.set_scale(window->calibration().imu, calibration.estimate_imu);
        const auto read = [&](double at_s) {
            ImuSample s = flight.imu(at_s);
            s.w_B -= wrong.gyro * s.w_B;
            s.a_B -= wrong.accel * s.a_B;
            return s;
        };
        ImuSample before = read(t - 0.2);
        for (int i = 1; i <= 40; ++i) {
            const ImuSample next = read(t - 0.2 + 0.005 * i);
            REQUIRE(ok(p.integrate(before, next, noise)));
            before = next;
        }
        REQUIRE(ok(window->add_keyframe(input, p)));
        REQUIRE_FALSE(window->optimize().solver.solver_failed);
    }
    StateCovariance covariance;
    REQUIRE(ok(window->newest_covariance(covariance)));
    return window;
}

SyntheticFlight lively_flight(unsigned seed) {
    SyntheticFlight::Options options;
    options.gyro_noise = 1.7e-4;
    options.accel_noise = 2e-3;
    options.pixel_sigma = 0.2;
    options.seed = seed;
    return SyntheticFlight(options);
}

}  // namespace

TEST_CASE("the calibration's prior is that of two cameras with errors of their own", "[calibration_prior]") {
    const StereoRig rig = test::make_rig();
    const CalibrationConfig config;
    const CalibrationMatrix covariance = calibration_covariance(config, rig);
    REQUIRE(covariance.rows() == kImuScale);
    // GIVEN draws of both cameras' poses on the body
    std::mt19937 generator(5);
    std::normal_distribution<double> normal;
    const auto draw = [&](double sigma) {
        return Eigen::Vector3d(sigma * normal(generator), sigma * normal(generator), sigma * normal(generator));
    };
    constexpr int kDraws = 4000;
    Eigen::Matrix<double, 12, 12> sampled = Eigen::Matrix<double, 12, 12>::Zero();
    for (int i = 0; i < kDraws; ++i) {
        const Se3 left{rig.T_B_C0.q * so3_exp(draw(config.camera_rotation_sigma_rad)),
                       rig.T_B_C0.p + draw(config.camera_position_sigma_m)};
        const Se3 right{rig.T_B_C1.q * so3_exp(draw(config.camera_rotation_sigma_rad)),
                        rig.T_B_C1.p + draw(config.camera_position_sigma_m)};
        // The parameters that say so: T_B_C0 = T_B_Bc T_Bc_C0 and T_B_C1 = T_B_Bc (T_Bc_C1 corrected).
        const Se3 T_B_Bc = left * rig.T_B_C0.inverse();
        const Se3 T_Bc_C1 = T_B_Bc.inverse() * right;
        Eigen::Matrix<double, 12, 1> d;
        d << so3_log(T_B_Bc.q), T_B_Bc.p, so3_log(rig.T_B_C1.q.conjugate() * T_Bc_C1.q), T_Bc_C1.p - rig.T_B_C1.p;
        sampled += d * d.transpose() / kDraws;
    }
    // THEN their covariance is the prior's, within what draws and the lever arm leave open
    Eigen::Matrix<double, 12, 12> expected;
    for (int i = 0; i < 12; ++i) {
        for (int j = 0; j < 12; ++j) {
            const auto row = [](int k) { return k < 6 ? kRigTheta + k : kRightTheta + k - 6; };
            expected(i, j) = covariance(row(i), row(j));
        }
    }
    const Eigen::VectorXd scale = expected.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd error = scale.asDiagonal() * (sampled - expected) * scale.asDiagonal();
    CHECK(error.cwiseAbs().maxCoeff() < 0.16);
    CHECK((scale.asDiagonal() * expected * scale.asDiagonal()).cwiseAbs().minCoeff() >= 0.0);
    CHECK(std::abs(expected(3, 9)) > 0.6 * std::sqrt(expected(3, 3) * expected(9, 9)));
    CalibrationMatrix information;
    REQUIRE(invert_covariance(covariance, information));
    CHECK((information * covariance - CalibrationMatrix::Identity(kImuScale, kImuScale)).cwiseAbs().maxCoeff() < 1e-8);
}

TEST_CASE("an invalid covariance is not inverted", "[calibration_prior]") {
    CalibrationMatrix information = CalibrationMatrix::Constant(2, 2, 7.0);
    CHECK_FALSE(invert_covariance(CalibrationMatrix::Constant(2, 2, 1.0) * -1.0, information));
    CHECK_FALSE(invert_covariance(CalibrationMatrix::Constant(2, 2, std::nan("")), information));
    CHECK(information(0, 0) == 7.0);
}

TEST_CASE("a window that restarts keeps what it knows of the calibration, or forgets all of it",
          "[calibration_prior]") {
    SyntheticFlight flight = lively_flight(3);
    CalibrationConfig calibration;
    calibration.estimate_extrinsics = true;
    const auto window = flown(calibration, flight, 30);
    const RigCalibration known = window->calibration();
    std::vector<double> sigma;
    for (int i = 0; i < calibration.dim(); ++i) {
        sigma.push_back(window->calibration_sigma(i));
    }
    REQUIRE(sigma[kRigTheta] < 0.5 * calibration.sigma(kRigTheta));
    const auto seen = flight.observe(6.0);
    const KeyframeInput input{test::at(6.0), flight.rate(6.0), false, {seen.data(), seen.size()}};
    const StateCovariance information = StateCovariance::Identity() * 1e4;

    const CalibrationStart start = GENERATE(CalibrationStart::kAsKnown, CalibrationStart::kAsGiven);
    window->start(input, flight.state(6.0), information, start);
    StateCovariance covariance;
    window->optimize();
    REQUIRE(ok(window->newest_covariance(covariance)));
    if (start == CalibrationStart::kAsKnown) {
        CHECK(known.box_minus_to(window->calibration()).norm() < 1e-9);
        for (int i = 0; i < calibration.dim(); ++i) {
            CAPTURE(i);
            CHECK(window->calibration_sigma(i) == Approx(sigma[static_cast<std::size_t>(i)]).epsilon(1e-3));
        }
    } else {
        CHECK(RigCalibration{}.box_minus_to(window->calibration()).norm() < 1e-9);
        CHECK(window->calibration_sigma(kRigTheta) == Approx(calibration.sigma(kRigTheta)).epsilon(1e-3));
    }
}

TEST_CASE("the scale of the IMU's axes is found in lively flight", "[calibration_prior]") {
    ImuScale wrong;  // half a percent and five milliradians, as data sheets allow
    wrong.gyro << 0.006, 0.003, -0.004, -0.003, -0.005, 0.004, 0.002, -0.003, 0.007;
    wrong.accel << -0.006, 0.0, 0.0, 0.004, 0.005, 0.0, -0.003, 0.004, 0.004;
    SyntheticFlight flight = lively_flight(4);
    CalibrationConfig calibration;
    calibration.estimate_imu = true;
    REQUIRE(calibration.dim() == kCalibrationDim);
    const auto window = flown(calibration, flight, 60, wrong);
    const ImuScale::Tangent found = ImuScale{}.box_minus_to(window->calibration().imu);
    const ImuScale::Tangent truth = ImuScale{}.box_minus_to(wrong);
    for (int i = 0; i < ImuScale::kDim; ++i) {
        const double sigma = window->calibration_sigma(kImuScale + i);
        CAPTURE(i, found(i), truth(i), sigma);
        CHECK(std::abs(found(i) - truth(i)) < 3.5 * sigma + 2e-4);  // 1 / (1 + s) is 1 - s to a few 1e-5
        CHECK(sigma < calibration.sigma(kImuScale + i));
    }
    // What turns the vehicle by radians is known to better than a thousandth.
    CHECK(window->calibration_sigma(kImuScale + 8) < 1e-3);
    CHECK(std::abs(found(8) - truth(8)) < 2e-3);
}

}  // namespace facet::calibration_prior_test
