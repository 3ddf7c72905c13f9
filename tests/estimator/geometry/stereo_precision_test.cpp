// SPDX-License-Identifier: BSD-2-Clause
// The covariance of a stereo point against closed forms, from the axis to the border of a fisheye.
#include "estimator/geometry/stereo_precision.h"

#include <catch2/catch.hpp>
#include <cmath>

namespace facet::stereo_precision_test {
namespace {

constexpr double kFocal = 300.0;
constexpr double kBaseline = 0.1;
constexpr double kSigma_px = 0.5;

StereoRig rig_with(Distortion distortion) {
    const CameraModel camera({700, 480, kFocal, kFocal, 349.5, 239.5, distortion, {}});
    StereoRig rig{camera, camera, {}, {}};
    rig.T_B_C1.p.x() = kBaseline;
    return rig;
}

double sigma_along(const Eigen::Matrix3d& covariance, const Eigen::Vector3d& direction) {
    return std::sqrt(direction.dot(covariance * direction));
}

}  // namespace

TEST_CASE("on the axis, depth and place have the textbook precision", "[stereo_precision]") {
    const StereoRig rig = rig_with(Distortion::kNone);
    const double z = 4.0;
    const Eigen::Matrix3d c = stereo_covariance(rig, rig.T_C1_C0(), {0.0, 0.0, z}, kSigma_px);
    CHECK(sigma_along(c, Eigen::Vector3d::UnitZ()) ==
          Approx(z * z * std::sqrt(2.0) * kSigma_px / (kFocal * kBaseline)).epsilon(0.02));
    CHECK(sigma_along(c, Eigen::Vector3d::UnitY()) == Approx(z * kSigma_px / (kFocal * std::sqrt(2.0))).epsilon(0.02));
}

TEST_CASE("a fisheye sees distance by the baseline across the ray", "[stereo_precision]") {
    const StereoRig rig = rig_with(Distortion::kEquidistant);
    const double distance = 2.0;
    for (const double angle : {0.2, 0.7, 1.2}) {
        CAPTURE(angle);
        const Eigen::Vector3d beside(std::sin(angle), 0.0, std::cos(angle));  // towards the baseline
        const Eigen::Vector3d below(0.0, std::sin(angle), std::cos(angle));   // across it
        const double best = distance * distance * std::sqrt(2.0) * kSigma_px / (kFocal * kBaseline);
        const auto seen = [&](const Eigen::Vector3d& ray) {
            return sigma_along(stereo_covariance(rig, rig.T_C1_C0(), distance * ray, kSigma_px), ray);
        };
        CHECK(seen(beside) == Approx(best / std::cos(angle)).epsilon(0.1));
        // Below, the disparity is an angle about the vertical, which the lens stretches by angle / sine.
        CHECK(seen(below) == Approx(best * std::sin(angle) / angle).epsilon(0.1));
    }
}

TEST_CASE("beyond the lens a point is as uncertain as it is far", "[stereo_precision]") {
    const StereoRig rig = rig_with(Distortion::kEquidistant);
    const Eigen::Vector3d behind(0.3, 0.2, -3.0);
    const Eigen::Matrix3d c = stereo_covariance(rig, rig.T_C1_C0(), behind, kSigma_px);
    CHECK(c.isApprox(behind.squaredNorm() * Eigen::Matrix3d::Identity(), 1e-9));
}

}  // namespace facet::stereo_precision_test
