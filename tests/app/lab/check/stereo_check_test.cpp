// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/check/stereo_check.h"

#include <array>
#include <catch2/catch.hpp>
#include <utility>

#include "app/lab/faults/calibration_error.h"
#include "app/lab/sim/default_rig.h"
#include "app/support/rng.h"

namespace facet::stereo_check_test {
namespace {

/// Points in front of a rig, as both of its cameras see them.
std::vector<PointPair> seen_by(const StereoRig& rig, int wanted = 300) {
    RandomStream random(3, 1);
    std::vector<PointPair> pairs;
    while (static_cast<int>(pairs.size()) < wanted) {
        const Eigen::Vector3d p_C0 =
            random.uniform(1.0, 8.0) * Eigen::Vector3d(random.uniform(-0.7, 0.7), random.uniform(-0.45, 0.45), 1.0);
        PointPair pair;
        if (ok(rig.left.project(p_C0, pair.first)) && ok(rig.right.project(rig.T_C1_C0() * p_C0, pair.second)) &&
            rig.left.in_image(pair.first, 5.0) && rig.right.in_image(pair.second, 5.0)) {
            pair.first += 0.1 * Eigen::Vector2d(random.normal(), random.normal());
            pair.second += 0.1 * Eigen::Vector2d(random.normal(), random.normal());
            pairs.push_back(pair);
        }
    }
    return pairs;
}

std::array<CheckVerdict, 2> judge(const StereoRig& claimed) {
    const std::vector<CheckVerdict> verdicts = check_stereo(claimed, seen_by(sim::euroc_rig()));
    REQUIRE(verdicts.size() == 2);
    return {verdicts[0], verdicts[1]};
}

bool says(const CheckVerdict& verdict, const char* words) {
    return verdict.level == CheckLevel::kWrong && verdict.sentence.find(words) != std::string::npos;
}

TEST_CASE("the distance to the epipolar line is that of the noise with the true rig") {
    const EpipolarFit fit = fit_epipolar(sim::euroc_rig(), seen_by(sim::euroc_rig()));
    // The median of |N(0, 0.1 px)|.
    CHECK(fit.median_px == Approx(0.0675).epsilon(0.2));
    CHECK(fit.in_front == Approx(1.0));
    CHECK(fit.points == 300);
}

TEST_CASE("a true and a good calibration are ok, a rough one is suspicious") {
    for (const CheckVerdict& verdict : judge(sim::euroc_rig())) {
        CHECK(verdict.level == CheckLevel::kOk);
    }
    StereoRig good = sim::euroc_rig();
    REQUIRE(add_calibration_error(1.0, 4, good));
    CHECK(judge(good)[0].level == CheckLevel::kOk);
    StereoRig rough = sim::euroc_rig();
    rough.T_B_C1.q = (rough.T_B_C1.q * so3_exp({0.004, 0.0, 0.0})).normalized();  // 1.8 px
    CHECK(judge(rough)[0].level == CheckLevel::kSuspicious);
    CHECK(judge(rough)[1].level == CheckLevel::kOk);
}

TEST_CASE("exchanged cameras, lenses and poses are named") {
    const StereoRig truth = sim::euroc_rig();
    StereoRig lenses = truth;
    std::swap(lenses.left, lenses.right);
    StereoRig poses = truth;
    std::swap(poses.T_B_C0, poses.T_B_C1);
    StereoRig both = lenses;
    std::swap(both.T_B_C0, both.T_B_C1);
    CHECK(says(judge(both)[1], "images of cam0 and cam1"));
    CHECK(says(judge(lenses)[1], "intrinsics of cam0 and cam1"));
    CHECK(says(judge(poses)[1], "poses of cam0 and cam1"));
    const StereoRig inverse{truth.left, truth.right, truth.T_B_C0.inverse(), truth.T_B_C1.inverse()};
    CHECK(says(judge(inverse)[1], "inverted"));
}

TEST_CASE("exchanged cameras of an ideal rig show by points behind the cameras alone") {
    StereoRig truth = sim::euroc_rig();
    truth.right = truth.left;
    truth.T_B_C1 = truth.T_B_C0 * Se3{Eigen::Quaterniond::Identity(), {0.1, 0.0, 0.0}};
    StereoRig claimed = truth;
    std::swap(claimed.T_B_C0, claimed.T_B_C1);
    const std::vector<CheckVerdict> verdicts = check_stereo(claimed, seen_by(truth));
    REQUIRE(verdicts.size() == 2);
    CHECK(verdicts[0].level == CheckLevel::kOk);
    CHECK(verdicts[1].level == CheckLevel::kWrong);
}

TEST_CASE("too few points, and one image twice") {
    const std::vector<CheckVerdict> verdicts = check_stereo(sim::euroc_rig(), seen_by(sim::euroc_rig(), 20));
    REQUIRE(verdicts.size() == 1);
    CHECK(verdicts[0].level == CheckLevel::kCannotTell);
    CHECK(check_same_image(std::array{0.0, 0.1, 0.0}, 90.0).level == CheckLevel::kWrong);
    CHECK(check_same_image(std::array{9.0, 0.1, 12.0}, 90.0).level == CheckLevel::kOk);
    CHECK(check_same_image({}, 0.0).level == CheckLevel::kCannotTell);
    // Black images are alike, whoever took them.
    const std::string dark = check_same_image(std::array{0.0, 0.1, 0.0}, 1.5).sentence;
    CHECK(dark.find("too dark to be compared: their mean is 1.5 of 255") != std::string::npos);
    CHECK(check_same_image(std::array{0.0, 0.1, 0.0}, 90.0).sentence.find("recorded twice") != std::string::npos);
}

}  // namespace
}  // namespace facet::stereo_check_test
