// SPDX-License-Identifier: BSD-2-Clause
// What may be claimed of a plane in the world.
#include "mesh/planes/plane_claim.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "estimator/geometry/so3.h"

namespace facet::plane_claim_test {
namespace {

using Eigen::Vector3d;

const PlaneCovariance kExact = PlaneCovariance::Zero();  // calibration

/// A wall 3 m ahead, 4 m to the side of the vehicle, of one landmark's worth.
PlaneFit wall() {
    PlaneFit fit;
    fit.normal_W = -Vector3d::UnitX();
    fit.distance_m = -3.0;
    fit.centroid_W = {3.0, 4.0, 1.0};
    fit.along_W = Vector3d::UnitY();
    fit.across_W = -Vector3d::UnitZ();
    fit.sigma_m = 0.002;
    fit.sigma_along_rad = 0.003;
    fit.sigma_across_rad = 0.004;
    fit.points = 1;
    return fit;
}

TEST_CASE("a plane seen from where the vehicle knows its place is known as well as its landmarks say") {
    const PlaneFit claim = claimed_in_world(wall(), {}, kExact);
    CHECK(claim.sigma_m == Approx(0.002));
    CHECK(claim.sigma_along_rad == Approx(0.003));
    CHECK(claim.sigma_across_rad == Approx(0.004));
    CHECK(claim.normal_W == wall().normal_W);
    CHECK(claim.distance_m == wall().distance_m);
}

TEST_CASE("many landmarks share errors: their number does not make a plane certain") {
    PlaneFit fit = wall();
    double last = 1.0;
    for (const int n : {10, 100, 1000, 100000}) {
        fit.points = n;
        fit.sigma_m = 0.01 / std::sqrt(n);  // each is known to 1 cm
        const double claim = claimed_in_world(fit, {}, kExact).sigma_m;
        CHECK(claim < last);
        CHECK(claim > std::sqrt(0.1) * 0.01);
        last = claim;
    }
    CHECK(last == Approx(std::sqrt(0.1) * 0.01).epsilon(1e-3));
}

TEST_CASE("drift of place and heading moves and turns a plane as drawn") {
    SightedFrom from;
    from.p_W = {0.0, 0.0, 1.0};
    from.covariance.diagonal() << 1e-4, 4e-4, 9e-4, 1e-4;  // 0.01 rad, 2, 3 and 1 cm
    from.covariance(0, 1) = from.covariance(1, 0) = 1e-4;
    const Eigen::Matrix4d root = from.covariance.llt().matrixL();
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    const auto drawn = [&](const PlaneFit& fit) {
        Vector3d squares = Vector3d::Zero();
        constexpr int kDraws = 20000;
        for (int i = 0; i < kDraws; ++i) {
            const Eigen::Vector4d e = root * Eigen::Vector4d::NullaryExpr([&] { return normal(random); });
            const Eigen::Matrix3d R = Eigen::AngleAxisd(e[0], Vector3d::UnitZ()).toRotationMatrix();
            const Vector3d c = from.p_W + R * (fit.centroid_W - from.p_W) + e.tail<3>();
            const Vector3d n = R * fit.normal_W;
            squares += Vector3d(fit.residual(c), n.dot(fit.along_W), n.dot(fit.across_W)).cwiseAbs2();
        }
        return Vector3d((squares / kDraws).cwiseSqrt());
    };
    for (const bool is_floor : {false, true}) {
        PlaneFit fit = wall();
        fit.sigma_m = fit.sigma_along_rad = fit.sigma_across_rad = 0.0;
        if (is_floor) {
            fit.normal_W = Vector3d::UnitZ();
            fit.distance_m = 1.0;
            fit.across_W = -Vector3d::UnitX();
        }
        const PlaneFit claim = claimed_in_world(fit, from, kExact);
        const Vector3d sigma = drawn(fit);
        CHECK(claim.sigma_m == Approx(sigma[0]).epsilon(0.03));
        CHECK(claim.sigma_along_rad == Approx(sigma[1]).epsilon(0.03).margin(1e-9));
        CHECK(claim.sigma_across_rad == Approx(sigma[2]).epsilon(0.03).margin(1e-9));
    }
}

/// Two cameras side by side, turned a little against each other and against the body.
StereoRig rig() {
    CameraIntrinsics lens;
    lens.width = 640;
    lens.height = 480;
    lens.fx = lens.fy = 400.0;
    lens.cx = 320.0;
    lens.cy = 240.0;
    StereoRig rig;
    rig.left = rig.right = CameraModel(lens);
    rig.T_B_C0 = {so3_exp(Vector3d(0.1, -0.2, 0.3)), Vector3d(0.05, 0.02, -0.01)};
    rig.T_B_C1 = rig.T_B_C0 * Se3{so3_exp(Vector3d(0.01, -0.02, 0.005)), Vector3d(0.12, 0.002, -0.003)};
    return rig;
}

/// Where a pair sees p_C0, seen again by a pair whose right camera is another one: the point nearest to both rays, in
/// the left camera's own.
Vector3d triangulated(const Vector3d& p_C0, const StereoRig& truth, const StereoRig& believed) {
    const Vector3d ray = p_C0 / p_C0.z();
    const Vector3d q = truth.T_C1_C0() * p_C0;
    const Eigen::Vector2d seen = q.head<2>() / q.z();
    double rho = 1.0 / p_C0.z();
    for (int step = 0; step < 10; ++step) {  // Gauss-Newton along the line
        const Se3 T = believed.T_C1_C0();
        const Vector3d at = T.q * ray + rho * T.p;
        Eigen::Matrix<double, 2, 3> d;
        d << 1.0, 0.0, -at.x() / at.z(), 0.0, 1.0, -at.y() / at.z();
        const Eigen::Vector2d line = d * T.p / at.z();
        rho += line.dot(seen - at.head<2>() / at.z()) / line.squaredNorm();
    }
    return ray / rho;
}

TEST_CASE("an uncertain right camera moves and turns a plane as drawn") {
    const StereoRig given = rig();
    const Se3 T_W_C0{so3_exp(Vector3d(-1.5, 0.3, 0.1)), Vector3d(1.0, 2.0, 1.5)};
    PlaneFit fit;
    fit.centroid_W = T_W_C0 * Vector3d(0.4, -0.3, 4.0);
    fit.normal_W = T_W_C0.q * Vector3d(0.3, 0.2, -1.0).normalized();
    fit.distance_m = fit.normal_W.dot(fit.centroid_W);
    fit.along_W = fit.normal_W.unitOrthogonal();
    fit.across_W = fit.normal_W.cross(fit.along_W);
    fit.extent_along_m = 0.8;
    fit.extent_across_m = 0.5;
    CameraCorrections cameras;
    const Eigen::Vector<double, 6> sigma =
        (Eigen::Vector<double, 6>() << 2e-4, 4e-4, 3e-4, 2e-4, 3e-4, 1e-4).finished();
    cameras.covariance.block<6, 6>(kLensDim, kLensDim) = sigma.cwiseAbs2().asDiagonal();
    const PlaneCovariance claimed = effect_of_calibration(fit, given, cameras, T_W_C0);
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    PlaneCovariance drawn = PlaneCovariance::Zero();
    constexpr int kDraws = 3000;
    for (int draw = 0; draw < kDraws; ++draw) {
        StereoRig truth = given;
        const Eigen::Vector<double, 6> e =
            sigma.cwiseProduct(Eigen::Vector<double, 6>::NullaryExpr([&] { return normal(random); }));
        truth.T_B_C1.q = given.T_B_C1.q * so3_exp(e.head<3>());
        truth.T_B_C1.p += e.tail<3>();
        Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
        Vector3d sum = Vector3d::Zero();
        for (double a = -1.0; a <= 1.0; a += 0.25) {
            for (double b = -1.0; b <= 1.0; b += 0.25) {
                const Vector3d at(1.0, a * fit.extent_along_m, b * fit.extent_across_m);
                const Vector3d p_W = fit.centroid_W + at[1] * fit.along_W + at[2] * fit.across_W;
                sum += at * fit.residual(T_W_C0 * triangulated(T_W_C0.inverse() * p_W, truth, given));
                moment += at * at.transpose();
            }
        }
        const Vector3d plane = moment.inverse() * sum;
        drawn += plane * plane.transpose() / kDraws;
    }
    for (int k = 0; k < 3; ++k) {
        CHECK(std::sqrt(claimed(k, k)) == Approx(std::sqrt(drawn(k, k))).epsilon(0.08));
    }
    CHECK(std::sqrt(claimed(0, 0)) > 0.01);  // it matters: 4 m away, a sigma is more than a centimetre
    PlaneFit claim = claimed_in_world(fit, {}, claimed);
    CHECK(claim.sigma_m == Approx(std::sqrt(claimed(0, 0))));
    CHECK(claim.sigma_across_rad == Approx(std::sqrt(claimed(2, 2))));
}

TEST_CASE("what both lenses have in common does not move a plane straight ahead, what they differ in does") {
    StereoRig pair = rig();
    pair.T_B_C1 = pair.T_B_C0 * Se3{Eigen::Quaterniond::Identity(), Vector3d(0.12, 0.0, 0.0)};
    PlaneFit fit;
    fit.normal_W = -Vector3d::UnitZ();
    fit.centroid_W = {0.0, 0.0, 3.0};
    fit.distance_m = -3.0;
    fit.along_W = Vector3d::UnitX();
    fit.across_W = -Vector3d::UnitY();
    fit.extent_along_m = fit.extent_across_m = 0.5;
    CameraCorrections cameras;
    const int left = kLensPrincipal;
    const int right = kLensDim + 6 + kLensPrincipal;
    cameras.covariance(left, left) = cameras.covariance(right, right) = 0.25;  // half a pixel
    const double apart = std::sqrt(effect_of_calibration(fit, pair, cameras, Se3{})(0, 0));
    CHECK(apart == Approx(std::sqrt(0.5) / 400.0 * 9.0 / 0.12).epsilon(0.01));  // z^2 / b of the disparity's error
    cameras.covariance(left, right) = cameras.covariance(right, left) = 0.25;
    CHECK(std::sqrt(std::max(0.0, effect_of_calibration(fit, pair, cameras, Se3{})(0, 0))) < 1e-3 * apart);
    CHECK(effect_of_calibration(fit, pair, cameras, Se3{Eigen::Quaterniond::Identity(), {0.0, 0.0, 9.0}}).isZero());
}

}  // namespace
}  // namespace facet::plane_claim_test
