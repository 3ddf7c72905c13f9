// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/check/turn_check.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "app/lab/sim/default_rig.h"
#include "app/support/rng.h"
#include "estimator/geometry/so3.h"

namespace facet::turn_check_test {
namespace {

constexpr double kDegPerRad = 57.29577951308232;

/// Which of the gyroscope's and the calibration's errors a recording has.
struct Recording {
    Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< readings = axes * true rates
    double unit = 1.0;
    double image_delay_s = 0.0;  ///< image stamps are early by it
    double liveliness = 1.0;
    bool yaw_only = false;
};

Eigen::Vector3d true_rate(double t, const Recording& r) {
    const Eigen::Vector3d w(0.6 * std::sin(2.1 * t), 0.5 * std::cos(1.3 * t + 0.4), 0.7 * std::sin(0.9 * t + 1.0));
    return r.liveliness * (r.yaw_only ? Eigen::Vector3d(0.0, 0.0, w.z()) : w);
}

Timestamp at_time(double t) { return Timestamp{} + Duration::from_seconds(100.0 + t); }

std::vector<CheckVerdict> judge(const Recording& r, const Eigen::Matrix3d& claimed_R_B_C) {
    const Eigen::Matrix3d R_B_C = sim::euroc_rig().T_B_C0.R();
    std::vector<ImuSample> samples;
    std::vector<CameraTurn> turns;
    RandomStream random(9, 1);
    Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
    Eigen::Quaterniond anchor = q;
    for (int i = 0; i < 2400; ++i) {
        const double t = i / 200.0;
        ImuSample sample;
        sample.stamp = at_time(t);
        sample.w_B = r.unit * (r.axes * true_rate(t, r));
        samples.push_back(sample);
        if (i % 30 == 0 && i > 0) {
            const Eigen::Vector3d error(random.normal(), random.normal(), random.normal());
            const Eigen::Vector3d theta_B = so3_log(anchor.conjugate() * q);
            turns.push_back({at_time(t - 0.15 - r.image_delay_s), at_time(t - r.image_delay_s),
                             R_B_C.transpose() * theta_B + 1e-3 * error});
            anchor = q;
        }
        q = (q * so3_exp(true_rate(t + 0.0025, r) / 200.0)).normalized();
    }
    const std::vector<CheckVerdict> verdicts = check_turns(turns, samples, claimed_R_B_C);
    REQUIRE(verdicts.size() == 3);
    return verdicts;
}

std::vector<CheckVerdict> judge(const Recording& r) { return judge(r, sim::euroc_rig().T_B_C0.R()); }

TEST_CASE("a right calibration is ok in axes, units and clocks") {
    for (const CheckVerdict& verdict : judge({})) {
        INFO(verdict.name << ": " << verdict.sentence);
        CHECK(verdict.level == CheckLevel::kOk);
    }
}

TEST_CASE("mixed-up axes are named, reflections too") {
    Recording r;
    r.axes << 0, 1, 0, -1, 0, 0, 0, 0, 1;
    const CheckVerdict turned = judge(r)[0];
    CHECK(turned.level == CheckLevel::kWrong);
    CHECK(turned.sentence.find("y -x z") != std::string::npos);
    r.axes = Eigen::Vector3d(1.0, -1.0, 1.0).asDiagonal();
    const CheckVerdict mirrored = judge(r)[0];
    CHECK(mirrored.level == CheckLevel::kWrong);
    CHECK(mirrored.sentence.find("x -y z") != std::string::npos);
}

TEST_CASE("an inverted and a slightly wrong rotation of the camera") {
    const Eigen::Matrix3d R_B_C = sim::euroc_rig().T_B_C0.R();
    const CheckVerdict inverted = judge({}, R_B_C.transpose())[0];
    CHECK(inverted.level == CheckLevel::kWrong);
    CHECK(inverted.sentence.find("inverted") != std::string::npos);
    const Eigen::Matrix3d off = R_B_C * so3_exp({0.0, 0.14, 0.0}).toRotationMatrix();
    CHECK(judge({}, off)[0].level == CheckLevel::kSuspicious);
}

TEST_CASE("degrees per second are named") {
    const CheckVerdict verdict = judge({.unit = kDegPerRad})[1];
    CHECK(verdict.level == CheckLevel::kWrong);
    CHECK(verdict.sentence.find("degrees") != std::string::npos);
    CHECK(judge({.unit = 1.2})[1].level == CheckLevel::kSuspicious);
}

TEST_CASE("a time offset is measured to a millisecond") {
    const CheckVerdict verdict = judge({.image_delay_s = 0.033})[2];
    CHECK(verdict.level == CheckLevel::kWrong);
    CHECK(verdict.figures[0].second == Approx(0.033).margin(1e-3));
    CHECK(judge({.image_delay_s = -0.012})[2].level == CheckLevel::kSuspicious);
    CHECK(judge({.image_delay_s = 0.002})[2].level == CheckLevel::kOk);
}

TEST_CASE("without turns nobody can tell, and turns about one axis do not show the others") {
    for (const CheckVerdict& verdict : judge({.liveliness = 0.01})) {
        CHECK(verdict.level == CheckLevel::kCannotTell);
    }
    CHECK(judge({.yaw_only = true})[0].level == CheckLevel::kCannotTell);
}

TEST_CASE("the rotation between two images is found beside a translation, with outliers") {
    const CameraModel camera = sim::euroc_rig().left;
    RandomStream random(11, 1);
    for (const double forward : {0.0, 0.1}) {
        const Eigen::Quaterniond q = so3_exp({0.03, -0.05, 0.02});
        const Eigen::Vector3d t(0.1, 0.02, forward);
        std::vector<PointPair> pairs;
        while (pairs.size() < 100) {
            const Eigen::Vector3d p1 =
                random.uniform(1.0, 6.0) * Eigen::Vector3d(random.uniform(-0.6, 0.6), random.uniform(-0.4, 0.4), 1.0);
            PointPair pair;
            if (ok(camera.project(q * p1 + t, pair.first)) && ok(camera.project(p1, pair.second))) {
                const double error_px = pairs.size() % 10 == 0 ? 20.0 : 0.1;
                pair.second += error_px * Eigen::Vector2d(random.normal(), random.normal());
                pairs.push_back(pair);
            }
        }
        const std::optional<Eigen::Vector3d> theta = estimate_turn(camera, pairs);
        REQUIRE(theta.has_value());
        CHECK((*theta - so3_log(q)).norm() < 3e-3);
        CHECK_FALSE(estimate_turn(camera, std::span(pairs).first(10)).has_value());
    }
}

}  // namespace
}  // namespace facet::turn_check_test
