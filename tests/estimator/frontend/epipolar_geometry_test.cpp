// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/epipolar_geometry.h"

#include <catch2/catch.hpp>

#include "tests/estimator/frontend/synthetic.h"

namespace facet::epipolar_geometry_test {
namespace {

constexpr double kInverseDepth = 0.4;

/// Corrections by three sigmas of a good calibration.
CameraCorrections three_sigmas() {
    CameraCorrections corrections;
    corrections.right = {so3_exp({1.5e-3, -1.2e-3, 2e-3}), {9e-4, -7e-4, 5e-4}};
    corrections.lens[0] << 1.5e-3, -1e-3, 0.9, -0.7, 1.5e-3, -1e-3, 2e-4, -2e-4;
    corrections.lens[1] << -1e-3, 1.2e-3, -0.6, 0.9, -1e-3, 1.5e-3, -2e-4, 1e-4;
    return corrections;
}

/// The rig that the corrections make of the given one.
StereoRig corrected(const StereoRig& given, const CameraCorrections& corrections) {
    StereoRig rig = given;
    rig.left = corrected(given.left, corrections.lens[0]);
    rig.right = corrected(given.right, corrections.lens[1]);
    rig.T_B_C1 = {given.T_B_C1.q * corrections.right.q, given.T_B_C1.p + corrections.right.p};
    return rig;
}

/// Calls `check(left_uv, right_uv)` with pixels of the same points in both cameras of a rig.
template <class Check>
void for_points(const StereoRig& rig, Check check) {
    int seen = 0;
    for (int v = 20; v < 240; v += 40) {
        for (int u = 60; u < 320; u += 40) {
            Eigen::Vector2d xy;
            REQUIRE(ok(rig.left.unproject(Eigen::Vector2d(u, v), xy)));
            const Eigen::Vector3d p_C0 = xy.homogeneous() / kInverseDepth;
            Eigen::Vector2d right;
            if (ok(rig.right.project(rig.T_C1_C0() * p_C0, right)) && rig.right.in_image(right, 0.0)) {
                check(Eigen::Vector2d(u, v), right);
                ++seen;
            }
        }
    }
    CHECK(seen > 25);
}

}  // namespace

TEST_CASE("the rig as given puts a point where its cameras see it", "[frontend]") {
    const StereoRig rig = synthetic::make_rig();
    EpipolarGeometry geometry;
    geometry.configure(rig);
    for_points(rig, [&](const Eigen::Vector2d& left, const Eigen::Vector2d& right) {
        EpipolarGeometry::Ray ray;
        REQUIRE(ok(geometry.ray_of(left, ray)));
        Eigen::Vector2d uv;
        Eigen::Matrix2f d_right_d_left;
        REQUIRE(ok(geometry.point_at(ray, kInverseDepth, uv, d_right_d_left)));
        CHECK((uv - right).norm() < 1e-6);
        EpipolarGeometry::Place place;
        REQUIRE(ok(geometry.compare(ray, right, place)));
        CHECK(place.off_px < 1e-6);
        CHECK(place.off_sigma_px == 0.0);
        CHECK(place.inverse_depth == Approx(kInverseDepth));
    });
}

TEST_CASE("corrections move curve, line and depth to those of the true rig", "[frontend]") {
    const StereoRig given = synthetic::make_rig();
    const CameraCorrections corrections = three_sigmas();
    EpipolarGeometry geometry;
    geometry.configure(given);
    geometry.correct(corrections);
    for_points(corrected(given, corrections), [&](const Eigen::Vector2d& left, const Eigen::Vector2d& right) {
        EpipolarGeometry::Ray ray;
        REQUIRE(ok(geometry.ray_of(left, ray)));
        Eigen::Vector2d uv;
        Eigen::Matrix2f d_right_d_left;
        REQUIRE(ok(geometry.point_at(ray, kInverseDepth, uv, d_right_d_left)));
        CHECK((uv - right).norm() < 0.05);  // the second order of both lenses' corrections
        EpipolarGeometry::Place place;
        REQUIRE(ok(geometry.compare(ray, right, place)));
        CHECK(place.off_px < 0.05);
        CHECK(place.inverse_depth == Approx(kInverseDepth).epsilon(0.01));

        // Both points stay those of the lenses as given.
        Eigen::Vector2d xy;
        REQUIRE(ok(given.left.unproject(left, xy)));
        CHECK(ray.given_xy == xy);
        REQUIRE(ok(given.right.unproject(right, xy)));
        CHECK(place.given_xy == xy);
    });
    geometry.configure(given);
    EpipolarGeometry::Ray ray;
    Eigen::Vector2d uv;
    Eigen::Matrix2f ignored;
    REQUIRE(ok(geometry.ray_of({160.0, 120.0}, ray)));
    REQUIRE(ok(geometry.point_at(ray, kInverseDepth, uv, ignored)));
    Eigen::Vector2d expected;
    REQUIRE(ok(given.right.project(given.T_C1_C0() * (ray.given_xy.homogeneous() / kInverseDepth), expected)));
    CHECK((uv - expected).norm() < 1e-9);
}

TEST_CASE("the sigma of the line is how far one sigma of a parameter moves it", "[frontend]") {
    constexpr double kStep = 1e-5;
    const StereoRig rig = synthetic::make_rig();
    EpipolarGeometry geometry;
    geometry.configure(rig);
    for (int i = 0; i < CameraCorrections::kDim; ++i) {
        CameraCorrections corrections;
        corrections.covariance(i, i) = kStep * kStep;
        Eigen::Matrix<double, CameraCorrections::kDim, 1> d = Eigen::Matrix<double, CameraCorrections::kDim, 1>::Zero();
        d(i) = kStep;
        CameraCorrections moved;
        moved.right = Se3{}.box_plus(d.segment<6>(kLensDim));
        moved.lens = {d.head<kLensDim>(), d.tail<kLensDim>()};
        for_points(rig, [&](const Eigen::Vector2d& left, const Eigen::Vector2d& right) {
            EpipolarGeometry::Ray ray;
            EpipolarGeometry::Place claimed;
            EpipolarGeometry::Place measured;
            geometry.correct(corrections);
            REQUIRE(ok(geometry.ray_of(left, ray)));
            REQUIRE(ok(geometry.compare(ray, right, claimed)));
            geometry.correct(moved);
            REQUIRE(ok(geometry.ray_of(left, ray)));
            REQUIRE(ok(geometry.compare(ray, right, measured)));
            CAPTURE(i, left.transpose());
            CHECK(claimed.off_sigma_px == Approx(measured.off_px).epsilon(0.02).margin(1e-7));
        });
    }
}

}  // namespace facet::epipolar_geometry_test
