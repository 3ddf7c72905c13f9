// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/faults/calibration_error.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "app/lab/sim/default_rig.h"

namespace facet::calibration_error_test {
namespace {

struct Errors {
    double principal_px = 0.0;
    double focal = 0.0;
    double radial = 0.0;
    double rotation_rad = 0.0;
    double place_m = 0.0;
};

/// Root mean squares over seeds of the left camera's errors; components of vectors count singly.
Errors root_mean_squares(double factor, int seeds) {
    const StereoRig truth = sim::euroc_rig();
    Errors sum;
    for (int seed = 0; seed < seeds; ++seed) {
        StereoRig rig = truth;
        REQUIRE(add_calibration_error(factor, static_cast<std::uint64_t>(seed), rig));
        const CameraIntrinsics& a = rig.left.intrinsics();
        const CameraIntrinsics& b = truth.left.intrinsics();
        sum.principal_px += std::pow(a.cx - b.cx, 2) + std::pow(a.cy - b.cy, 2);
        sum.focal += std::pow(a.fx / b.fx - 1.0, 2) + std::pow(a.fy / b.fy - 1.0, 2);
        sum.radial += std::pow(a.coeffs[0] - b.coeffs[0], 2) + std::pow(a.coeffs[1] - b.coeffs[1], 2);
        sum.rotation_rad += so3_log(truth.T_B_C0.q.conjugate() * rig.T_B_C0.q).squaredNorm();
        sum.place_m += (rig.T_B_C0.p - truth.T_B_C0.p).squaredNorm();
    }
    const auto rms = [&](double squares, int components) { return std::sqrt(squares / (components * seeds)); };
    return {rms(sum.principal_px, 2), rms(sum.focal, 2), rms(sum.radial, 2), rms(sum.rotation_rad, 3),
            rms(sum.place_m, 3)};
}

TEST_CASE("errors of a calibration have the sigmas of a good one, times the factor") {
    const CalibrationSigmas sigmas;
    for (const double factor : {1.0, 2.0}) {
        const Errors errors = root_mean_squares(factor, 400);
        CHECK(errors.principal_px == Approx(factor * sigmas.principal_px).epsilon(0.1));
        CHECK(errors.focal == Approx(factor * sigmas.focal).epsilon(0.1));
        CHECK(errors.radial == Approx(factor * sigmas.radial).epsilon(0.1));
        CHECK(errors.rotation_rad == Approx(factor * sigmas.rotation_rad).epsilon(0.1));
        CHECK(errors.place_m == Approx(factor * sigmas.place_m).epsilon(0.1));
    }
}

TEST_CASE("the errors of a seed are proportional to the factor, the same each time, and the cameras' own") {
    const StereoRig truth = sim::euroc_rig();
    StereoRig once = truth;
    StereoRig twice = truth;
    REQUIRE(add_calibration_error(1.0, 7, once));
    REQUIRE(add_calibration_error(2.0, 7, twice));
    const double cx = truth.left.intrinsics().cx;
    CHECK(twice.left.intrinsics().cx - cx == Approx(2.0 * (once.left.intrinsics().cx - cx)));
    StereoRig again = truth;
    REQUIRE(add_calibration_error(1.0, 7, again));
    CHECK(again.T_B_C1.p == once.T_B_C1.p);
    CHECK(again.right.intrinsics().cx == once.right.intrinsics().cx);
    CHECK(std::abs((once.right.intrinsics().cx - truth.right.intrinsics().cx) - (once.left.intrinsics().cx - cx)) >
          1e-3);
    StereoRig other = truth;
    REQUIRE(add_calibration_error(1.0, 8, other));
    CHECK(other.left.intrinsics().cx != once.left.intrinsics().cx);
}

TEST_CASE("errors with heavy tails have the same median, and far more of more than four sigmas") {
    const StereoRig truth = sim::euroc_rig();
    const double sigma = CalibrationSigmas{}.principal_px;
    int beyond_median = 0;
    int far = 0;
    constexpr int kSeeds = 1000;
    for (int seed = 0; seed < kSeeds; ++seed) {
        StereoRig rig = truth;
        REQUIRE(add_calibration_error(1.0, static_cast<std::uint64_t>(seed), rig, ErrorDraw::kTails));
        const double error = std::abs(rig.left.intrinsics().cx - truth.left.intrinsics().cx) / sigma;
        beyond_median += error > 0.765 ? 1 : 0;  // of the absolute value of Student's t, three degrees of freedom
        far += error > 4.0 ? 1 : 0;              // 2.8 %; of a normal number 0.006 %
    }
    CHECK(beyond_median == Approx(kSeeds / 2).margin(60));
    CHECK(far > 10);
    CHECK(far < 50);
}

TEST_CASE("without error the rig stays, and one that cannot be used is refused") {
    const StereoRig truth = sim::euroc_rig();
    StereoRig rig = truth;
    REQUIRE(add_calibration_error(0.0, 3, rig));
    CHECK(rig.left.intrinsics().cx == truth.left.intrinsics().cx);
    CHECK((rig.T_B_C0.p - truth.T_B_C0.p).norm() == 0.0);
    StereoRig broken = truth;
    CHECK_FALSE(add_calibration_error(1e4, 3, broken));
    CHECK(broken.left.intrinsics().cx == truth.left.intrinsics().cx);
}

}  // namespace
}  // namespace facet::calibration_error_test
