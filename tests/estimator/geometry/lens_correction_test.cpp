// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/geometry/lens_correction.h"

#include <catch2/catch.hpp>

namespace facet::lens_correction_test {
namespace {

CameraIntrinsics pinhole(Distortion distortion) {
    CameraIntrinsics k{752, 480, 458.7, 457.3, 367.2, 248.4, distortion, {}};
    if (distortion == Distortion::kRadialTangential) {
        k.coeffs = {-0.283, 0.074, 2e-4, 2e-5};
    } else if (distortion == Distortion::kEquidistant) {
        k.coeffs = {-0.013, 0.02, -0.012, 0.002};
    } else if (distortion == Distortion::kRational) {
        k.coeffs = {4.84, 2.93, 1.7e-4, -6e-5};
        k.more = {0.13, 5.17, 4.61, 0.73};
    } else if (distortion == Distortion::kUnified) {
        k.coeffs = {-0.12, 0.21, 4e-4, -3e-4};
        k.more = {1.02, 0.0, 0.0, 0.0};
    } else if (distortion == Distortion::kDoubleSphere) {
        k.coeffs = {-0.18, 0.59, 0.0, 0.0};
    } else if (distortion == Distortion::kEucm) {
        k.coeffs = {0.627, 1.058, 0.0, 0.0};
    } else if (distortion == Distortion::kFov) {
        k.coeffs = {0.93, 0.0, 0.0, 0.0};
    }
    return k;
}

CameraIntrinsics by_hand(const CameraIntrinsics& k, const LensCorrection& d) {
    CameraIntrinsics c = k;
    c.fx *= 1.0 + d(0);
    c.fy *= 1.0 + d(1);
    c.cx += d(2);
    c.cy += d(3);
    for (int i = 0; i < 4; ++i) {
        c.coeffs[static_cast<std::size_t>(i)] += d(kLensDistortion + i);
    }
    return c;
}

}  // namespace

TEST_CASE("a corrected point is where the corrected camera sees the pixel", "[lens_correction]") {
    const Distortion distortion = GENERATE(Distortion::kNone, Distortion::kRadialTangential, Distortion::kEquidistant);
    const CameraIntrinsics given = pinhole(distortion);
    const CameraModel camera(given);
    LensCorrection correction;
    correction << 1e-3, -8e-4, 0.6, -0.4, 1e-3, -1.5e-3, 2e-4, -3e-4;
    if (distortion == Distortion::kNone) {
        correction.tail<4>().setZero();
    }
    const CameraModel truth(by_hand(given, correction));
    for (const double u : {20.0, 367.0, 500.0, 730.0}) {
        for (const double v : {15.0, 248.0, 460.0}) {
            Eigen::Vector2d xy;
            Eigen::Vector2d expected;
            REQUIRE(ok(camera.unproject({u, v}, xy)));
            REQUIRE(ok(truth.unproject({u, v}, expected)));
            const Eigen::Vector2d found = xy + d_xy_d_lens(camera, xy).cast<double>() * correction;
            INFO("pixel " << u << " " << v << ", correction " << (expected - xy).transpose());
            // Corrections of two to three sigmas of a good calibration: six hundredths of a pixel, in the corners.
            CHECK((found - expected).norm() < 0.07 / 458.0);
            CHECK((found - expected).norm() < 0.03 * (expected - xy).norm() + 1e-9);
        }
    }
}

TEST_CASE("each column is the derivative by its parameter", "[lens_correction]") {
    const Distortion distortion =
        GENERATE(Distortion::kRadialTangential, Distortion::kEquidistant, Distortion::kRational, Distortion::kUnified,
                 Distortion::kDoubleSphere, Distortion::kEucm, Distortion::kFov);
    const CameraIntrinsics given = pinhole(distortion);
    const CameraModel camera(given);
    const Eigen::Vector2d uv(610.0, 101.0);
    Eigen::Vector2d xy;
    REQUIRE(ok(camera.unproject(uv, xy)));
    const Eigen::Matrix<double, 2, kLensDim> jacobian = d_xy_d_lens(camera, xy).cast<double>();
    for (int i = 0; i < kLensDim; ++i) {
        const bool is_principal = i >= kLensPrincipal && i < kLensDistortion;
        const double step = is_principal ? 1e-3 : 1e-6;
        LensCorrection d = LensCorrection::Zero();
        d(i) = step;
        Eigen::Vector2d plus;
        Eigen::Vector2d minus;
        REQUIRE(ok(CameraModel(by_hand(given, d)).unproject(uv, plus)));
        REQUIRE(ok(CameraModel(by_hand(given, -d)).unproject(uv, minus)));
        INFO("lens " << static_cast<int>(distortion) << ", parameter " << i);
        CHECK((jacobian.col(i) - (plus - minus) / (2.0 * step)).norm() < 1e-6 + 1e-5 * jacobian.col(i).norm());
    }
}

TEST_CASE("on the axis of a fisheye the coefficients have no effect", "[lens_correction]") {
    const LensJacobian jacobian = d_xy_d_lens(CameraModel(pinhole(Distortion::kEquidistant)), {0.0, 0.0});
    CHECK(jacobian.allFinite());
    CHECK(jacobian.rightCols<4>().norm() == 0.0F);
}

}  // namespace facet::lens_correction_test
