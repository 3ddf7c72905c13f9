// SPDX-License-Identifier: BSD-2-Clause
// One factor on all standard deviations of a calibration, learnt from the parameters that a flight shows.
#include "estimator/window/calibration_quality.h"

#include <Eigen/Cholesky>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

namespace facet::calibration_quality_test {
namespace {

using Correction = CalibrationQuality::Correction;
using Covariance = CalibrationQuality::Covariance;

StereoRig simple_rig() {
    StereoRig rig;
    rig.T_B_C1.p = {0.1, 0.0, 0.0};
    return rig;
}

Covariance of_cameras(const CalibrationMatrix& all) {
    return all.block<kCameraTermsDim, kCameraTermsDim>(kRigDim, kRigDim);
}

/// What K becomes where the calibration's errors are `truth` times as large as stated, and all parameters but the last
/// `hidden` are seen to a tenth of their stated deviation.
double learnt(double truth, int hidden, unsigned seed) {
    const CalibrationMatrix all = calibration_covariance({}, simple_rig());
    const Covariance given = of_cameras(all);
    const Eigen::LLT<Covariance> llt(given);
    std::mt19937 rng(seed);
    std::normal_distribution<double> normal;
    Correction white;
    for (double& value : white) {
        value = truth * normal(rng);
    }
    const Correction error = llt.matrixL() * white;
    Covariance seen = Covariance::Zero();
    Correction shown = Correction::Zero();
    for (int i = 0; i < kCameraTermsDim - hidden; ++i) {
        seen(i, i) = 100.0 / given(i, i);
        shown(i) = error(i) + 0.1 * std::sqrt(given(i, i)) * normal(rng);
    }
    CalibrationQuality quality;
    quality.reset(all);
    for (int step = 0; step < 100; ++step) {
        Covariance information = llt.solve(Covariance::Identity()) / std::pow(quality.scale(), 2);
        information += seen;
        const Covariance covariance = information.llt().solve(Covariance::Identity());
        quality.learn(covariance * (seen * shown), covariance);
    }
    return quality.scale();
}

double mean_learnt(double truth, int hidden) {
    constexpr unsigned kDraws = 20;
    double sum = 0.0;
    for (unsigned seed = 1; seed <= kDraws; ++seed) {
        sum += learnt(truth, hidden, seed) / kDraws;
    }
    return sum;
}

}  // namespace

TEST_CASE("a calibration's quality is found from the parameters that are seen") {
    for (const int hidden : {0, 6, 12}) {
        CAPTURE(hidden);
        CHECK(mean_learnt(0.0, hidden) < 0.4);
        CHECK(mean_learnt(0.5, hidden) == Approx(0.5).epsilon(0.25));
        CHECK(mean_learnt(1.0, hidden) == Approx(1.0).epsilon(0.15));
        CHECK(mean_learnt(2.0, hidden) == Approx(2.0).epsilon(0.15));
        CHECK(mean_learnt(50.0, hidden) == Approx(5.0));
    }
}

TEST_CASE("where nothing is seen the calibration is as good as stated") {
    CHECK(learnt(3.0, kCameraTermsDim, 1) == Approx(1.0));
}

TEST_CASE("values that are NaN are not learnt from") {
    const CalibrationMatrix all = calibration_covariance({}, simple_rig());
    CalibrationQuality quality;
    quality.reset(all);
    quality.learn(Correction::Constant(std::nan("")), of_cameras(all));
    CHECK(quality.scale() == 1.0);
}

TEST_CASE("the scale is that of the cameras' deviations, not of the time offset or the IMU") {
    CalibrationConfig config;
    config.estimate_imu = true;
    const CalibrationMatrix all = calibration_covariance(config, simple_rig());
    CalibrationMatrix information;
    REQUIRE(invert_covariance(all, information));
    CalibrationQuality quality;
    quality.reset(all);
    quality.learn(2.0 * of_cameras(all).diagonal().cwiseSqrt(), Covariance::Zero());
    const double squared = std::pow(quality.scale(), 2);
    CHECK(squared > 2.0);
    const CalibrationMatrix scaled = quality.scaled(information, kRigTheta);
    CHECK(scaled(kTimeOffset, kTimeOffset) == information(kTimeOffset, kTimeOffset));
    CHECK(scaled(kRigPos, kRightPos) == Approx(information(kRigPos, kRightPos) / squared));
    CHECK(scaled(kRightLens, kRightLens) == Approx(information(kRightLens, kRightLens) / squared));
    CHECK(scaled(kImuScale, kImuScale) == information(kImuScale, kImuScale));

    const CalibrationMatrix but_pair = quality.scaled(information, kRigDim);
    CHECK(but_pair(kRigPos, kRigPos) == information(kRigPos, kRigPos));
    CHECK(but_pair(kRigPos, kRightPos) == Approx(information(kRigPos, kRightPos) / quality.scale()));
    CHECK(but_pair(kRightPos, kRightPos) == Approx(information(kRightPos, kRightPos) / squared));
}

}  // namespace facet::calibration_quality_test
