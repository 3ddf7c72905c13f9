// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/truth_fit.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "estimator/geometry/so3.h"

namespace facet::truth_fit_test {
namespace {

const Eigen::Vector3d kLeverArm(0.02, -0.01, 0.03);  // m
const Eigen::Vector3d kTurn(0.004, -0.002, 0.006);   // rad

Eigen::Vector3d place(double s) { return {2.0 * std::cos(0.5 * s), 1.5 * std::sin(0.7 * s), 0.3 * std::sin(0.9 * s)}; }

Eigen::Quaterniond attitude(double s) {
    return so3_exp(Eigen::Vector3d(0.3 * std::sin(1.3 * s), 0.2 * std::cos(0.8 * s), 0.4 * s));
}

struct Truth {
    double late_s = 0.0;
    double turned_late_s = 0.0;
    Eigen::Vector3d lever_arm = Eigen::Vector3d::Zero();
    Eigen::Vector3d turn = Eigen::Vector3d::Zero();
};

/// The true pose of a stamp: late, of another point and in other axes than the estimate's.
Se3 true_pose(const Truth& truth, double s) {
    const double place_s = s - truth.late_s;
    return {attitude(s - truth.turned_late_s) * so3_exp(-truth.turn),
            place(place_s) - attitude(place_s) * truth.lever_arm};
}

/// A flight at 20 Hz; the estimate is in a world of its own.
std::vector<PosePair> pairs(double seconds, const Truth& truth) {
    const Se3 T{so3_exp(Eigen::Vector3d(0.1, -0.3, 2.0)), {1.0, 2.0, 3.0}};
    std::vector<PosePair> result;
    for (int i = 0; i <= static_cast<int>(20 * seconds); ++i) {
        const double s = 0.05 * i;
        result.push_back({.stamp = Timestamp{static_cast<std::int64_t>(i) * 50'000'000},
                          .truth = true_pose(truth, s),
                          .estimate = T * Se3{attitude(s), place(s)}});
    }
    return result;
}

TEST_CASE("lags, lever arm and turn of a ground truth are found together") {
    const TruthFit fit = fit_truth(pairs(20.0, {0.010, -0.002, kLeverArm, kTurn}));
    REQUIRE(fit.is_known);
    CHECK(fit.lag_s.value == Approx(0.010).epsilon(0.02));
    CHECK(fit.orientation_lag_s.value == Approx(-0.002).epsilon(0.05));
    CHECK((fit.lever_arm_m.value - kLeverArm).norm() < 3e-4);
    CHECK((fit.turn_rad.value - kTurn).norm() < 1e-4);
    CHECK(fit.scale.value == Approx(1.0).margin(2e-4));
    CHECK(fit.position_rmse_m < 2e-4);
    CHECK(fit.orientation_rmse_rad < 1e-4);
}

TEST_CASE("scale is fitted apart from lag and lever arm") {
    std::vector<PosePair> flight = pairs(20.0, {.late_s = 0.005, .lever_arm = kLeverArm});
    for (PosePair& pair : flight) {
        pair.estimate.p *= 1.01;
    }
    const TruthFit fit = fit_truth(flight);
    CHECK(fit.scale.value == Approx(1.0 / 1.01).margin(2e-4));
    CHECK(fit.lag_s.value == Approx(0.005).epsilon(0.03));
}

TEST_CASE("sigmas cover the errors of fits, whether or not neighbouring errors are alike") {
    const double memory = GENERATE(0.0, 0.9);
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    double squares = 0.0;
    constexpr int kFlights = 60;
    for (int flight = 0; flight < kFlights; ++flight) {
        std::vector<PosePair> noisy = pairs(20.0, {});
        Eigen::Vector3d error = Eigen::Vector3d::Zero();
        for (PosePair& pair : noisy) {
            const Eigen::Vector3d fresh(normal(random), normal(random), normal(random));
            error = memory * error + std::sqrt(1.0 - memory * memory) * 0.003 * fresh;
            pair.estimate.p += error;
        }
        const TruthFit fit = fit_truth(noisy);
        squares += std::pow(fit.lag_s.value / fit.lag_s.sigma, 2) / kFlights;
    }
    CHECK(squares > 0.5);
    CHECK(squares < 2.0);
}

TEST_CASE("what is left within a second is separate from what changes slowly") {
    std::vector<PosePair> flight = pairs(20.0, {});
    for (PosePair& pair : flight) {  // 3 mm that change slowly, 1 mm at 4 Hz
        const double s = pair.stamp.seconds();
        pair.estimate.p += std::sqrt(2.0) * Eigen::Vector3d(0.003 * std::sin(0.9 * s), 0.001 * std::sin(25.0 * s), 0.0);
    }
    const TruthFit fit = fit_truth(flight);
    CHECK(fit.position_rmse_m > 0.002);
    CHECK(fit.position_swift_rmse_m == Approx(0.001).margin(0.0002));
    CHECK(fit.orientation_swift_rmse_rad < 1e-6);
}

TEST_CASE("a truth is left as it is by what its fit does not show") {
    const std::vector<GroundTruthState> states{{.stamp = Timestamp{0}, .p_W_B = {0.0, 0.0, 0.0}},
                                               {.stamp = Timestamp{50'000'000}, .p_W_B = {0.1, 0.0, 0.0}},
                                               {.stamp = Timestamp{100'000'000}, .p_W_B = {0.2, 0.0, 0.0}}};
    TruthFit fit;
    fit.is_known = true;
    fit.lag_s = {0.002, 0.001};
    fit.lever_arm_m = {{0.01, 0.0, 0.02}, {0.005, 0.001, 0.01}};
    fit.turn_rad = {{0.02, 0.0, 0.0}, {0.01, 0.001, 0.001}};
    const std::vector<GroundTruthState> unshown = with_fit(states, fit);
    REQUIRE(unshown.size() == 1);
    CHECK((unshown[0].p_W_B - states[1].p_W_B).norm() < 1e-12);
    CHECK(unshown[0].q_W_B.angularDistance(states[1].q_W_B) < 1e-12);
    fit.lever_arm_m.sigma.setConstant(0.005);
    const std::vector<GroundTruthState> shown = with_fit(states, fit);
    REQUIRE(shown.size() == 1);
    CHECK((shown[0].p_W_B - states[1].p_W_B - fit.lever_arm_m.value).norm() < 1e-12);
}

TEST_CASE("a vehicle that never turns leaves the lever arm open") {
    std::vector<PosePair> flight = pairs(20.0, {.late_s = 0.010});
    for (PosePair& pair : flight) {
        pair.truth.q = Eigen::Quaterniond::Identity();
        pair.estimate.q = so3_exp(Eigen::Vector3d(0.1, -0.3, 2.0));
        pair.estimate.p += Eigen::Vector3d(1e-4 * std::sin(40.0 * pair.stamp.seconds()), 0.0, 0.0);
    }
    const TruthFit fit = fit_truth(flight);
    REQUIRE(fit.is_known);
    CHECK(fit.lag_s.value == Approx(0.010).epsilon(0.02));
    CHECK(fit.lever_arm_m.value.norm() < 0.01);
    CHECK(fit.lever_arm_m.sigma.minCoeff() > 0.1);
}

TEST_CASE("a vehicle that stands, or hardly any poses, determine nothing") {
    CHECK_FALSE(fit_truth({}).is_known);
    CHECK_FALSE(fit_truth(pairs(1.0, {.late_s = 0.01})).is_known);
    std::vector<PosePair> standing = pairs(20.0, {});
    for (PosePair& pair : standing) {
        pair.truth = standing.front().truth;
        pair.estimate = standing.front().estimate;
    }
    CHECK_FALSE(fit_truth(standing).is_known);
}

TEST_CASE("a truth with its fit is that of the estimate's body") {
    const Truth truth{0.010, -0.002, kLeverArm, kTurn};
    std::vector<GroundTruthState> states;
    for (int i = 0; i <= 4000; ++i) {
        const double s = 0.005 * i;
        const Se3 pose = true_pose(truth, s);
        const Eigen::Vector3d v = (true_pose(truth, s + 1e-4).p - true_pose(truth, s - 1e-4).p) / 2e-4;
        states.push_back({.stamp = Timestamp{static_cast<std::int64_t>(i) * 5'000'000},
                          .p_W_B = pose.p,
                          .q_W_B = pose.q,
                          .has_motion = true,
                          .v_W_B = v});
    }
    TruthFit fit;
    fit.is_known = true;
    fit.lag_s.value = truth.late_s;
    fit.orientation_lag_s.value = truth.turned_late_s;
    fit.lever_arm_m.value = kLeverArm;
    fit.turn_rad.value = kTurn;
    const std::vector<GroundTruthState> fitted = with_fit(states, fit);
    REQUIRE(fitted.size() > 3900);
    for (const GroundTruthState& state : fitted) {
        const double s = state.stamp.seconds();
        const Eigen::Vector3d v = (place(s + 1e-4) - place(s - 1e-4)) / 2e-4;
        REQUIRE((state.p_W_B - place(s)).norm() < 2e-4);
        REQUIRE((state.v_W_B - v).norm() < 2e-3);
        REQUIRE(so3_log((attitude(s).conjugate() * state.q_W_B).normalized()).norm() < 2e-4);
    }
}

}  // namespace
}  // namespace facet::truth_fit_test
