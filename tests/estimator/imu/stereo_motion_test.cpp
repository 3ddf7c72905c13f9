// SPDX-License-Identifier: BSD-2-Clause
// Motion from stereo points: exact on exact points, within its covariance with noise, unmoved by outliers.
#include "estimator/imu/stereo_motion.h"

#include <Eigen/Cholesky>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "estimator/geometry/so3.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/check_fields.h"

namespace facet {
namespace {

constexpr double kFocal_px = 450.0;
constexpr double kBaseline_m = 0.1;
constexpr double kSigma_px = 0.5;

using Vector6 = Eigen::Matrix<double, 6, 1>;

struct Scene {
    Se3 T_B_C{so3_exp({1.2, -1.1, 1.3}), {0.02, -0.06, 0.01}};
    Se3 T_Bi_Bj{so3_exp({0.05, -0.1, 0.08}), {0.3, -0.1, 0.2}};
    std::vector<StereoPoint> points;

    /// Points at 1 to 12 m before the camera, both views with noise, the first `outliers` replaced by
    /// points that all moved alike, another way.
    Scene(int count, int outliers, double noise_scale, unsigned seed) {
        std::mt19937 rng(seed);
        std::normal_distribution<double> normal;
        std::uniform_real_distribution<double> uniform(-1.0, 1.0);
        const auto noisy = [&](const Eigen::Vector3d& p) -> StereoPlace {
            // pixel noise of left x, y and right x, turned into a point by the disparity
            const double s = noise_scale * kSigma_px / kFocal_px;
            const double x = p.x() / p.z() + s * normal(rng);
            const double y = p.y() / p.z() + s * normal(rng);
            const double disparity = kBaseline_m / p.z() + s * std::sqrt(2.0) * normal(rng);
            const Eigen::Vector3d seen = kBaseline_m / disparity * Eigen::Vector3d(x, y, 1.0);
            return {seen, covariance_of(seen)};
        };
        const Se3 T_Ci_Cj = T_B_C.inverse() * T_Bi_Bj * T_B_C;
        while (static_cast<int>(points.size()) < count) {
            const double z = std::exp(1.25 + 1.25 * uniform(rng));
            const Eigen::Vector3d then(0.7 * z * uniform(rng), 0.5 * z * uniform(rng), z);
            Eigen::Vector3d now = T_Ci_Cj.inverse() * then;
            if (static_cast<int>(points.size()) < outliers) {
                now += Eigen::Vector3d(0.8, 0.1, -0.3);
            }
            if (now.z() > 0.5) {
                points.push_back({noisy(then), noisy(now)});
            }
        }
    }
    /// Lateral z sigma / f, along the ray z^2 sqrt(2) sigma / (f b).
    static Eigen::Matrix3d covariance_of(const Eigen::Vector3d& p) {
        const double lateral = p.z() * kSigma_px / kFocal_px;
        const double along = lateral * std::sqrt(2.0) / kBaseline_m;
        return lateral * lateral * Eigen::Matrix3d::Identity() + along * along * p * p.transpose();
    }
    Vector6 error(const StereoMotion& m) const {
        Vector6 e;
        e << so3_log(m.q_Bi_Bj.conjugate() * T_Bi_Bj.q), T_Bi_Bj.p - m.p_Bi_Bj;
        return e;
    }
};

}  // namespace

TEST_CASE("exact points give the exact motion, from a wrong rotation too") {
    const StereoMotionConfig config;
    const Scene scene(60, 0, 0.0, 1);
    StereoMotion m;
    const Eigen::Quaterniond gyro = scene.T_Bi_Bj.q * so3_exp({0.01, -0.02, 0.01});
    REQUIRE(ok(estimate_stereo_motion(scene.points, scene.T_B_C, gyro, config, m)));
    CHECK(scene.error(m).tail<3>().norm() < 2e-4);
    CHECK(scene.error(m).head<3>().norm() < 2e-4);
    CHECK(m.inliers == 60);
}

TEST_CASE("errors are of the size the covariance says, with the rotation open and given") {
    for (const double rotation_sigma : {0.1, 1e-3}) {
        CAPTURE(rotation_sigma);
        StereoMotionConfig config;
        config.rotation_sigma_rad = rotation_sigma;
        std::mt19937 rng(2);
        std::normal_distribution<double> normal;
        constexpr int kRuns = 200;
        double nees = 0.0;
        double position = 0.0;
        for (unsigned run = 0; run < kRuns; ++run) {
            const Scene scene(80, 0, 1.0, run + 1);
            const double gyro_error = std::min(rotation_sigma, 0.01);
            const Eigen::Vector3d wrong = gyro_error * Eigen::Vector3d(normal(rng), normal(rng), normal(rng));
            StereoMotion m;
            REQUIRE(ok(estimate_stereo_motion(scene.points, scene.T_B_C, scene.T_Bi_Bj.q * so3_exp(wrong), config, m)));
            const Vector6 e = scene.error(m);
            nees += e.dot(m.covariance.llt().solve(e)) / (6.0 * kRuns);
            position += e.tail<3>().norm() / kRuns;
        }
        CHECK(nees < 1.5);
        CHECK(nees > 0.6);
        CHECK(position < 0.01);
    }
}

TEST_CASE("a third of outliers that agree with each other changes little") {
    StereoMotionConfig config;
    config.rotation_sigma_rad = 2e-3;
    for (unsigned seed = 1; seed <= 50; ++seed) {
        const Scene scene(90, 30, 1.0, seed);
        StereoMotion m;
        REQUIRE(ok(estimate_stereo_motion(scene.points, scene.T_B_C, scene.T_Bi_Bj.q, config, m)));
        CHECK(scene.error(m).tail<3>().norm() < 0.03);
        CHECK(m.inliers < 75);
        CHECK(m.inliers > 50);
    }
}

TEST_CASE("too few points, or none that agree, are degenerate; impossible points are left out; nothing is allocated") {
    const StereoMotionConfig config;
    Scene scene(40, 0, 1.0, 3);
    StereoMotion m;
    m.inliers = -1;
    const Eigen::Quaterniond& q = scene.T_Bi_Bj.q;
    CHECK(estimate_stereo_motion({scene.points.data(), 5}, scene.T_B_C, q, config, m) == Status::kDegenerate);
    CHECK(estimate_stereo_motion({}, scene.T_B_C, q, config, m) == Status::kDegenerate);
    CHECK(m.inliers == -1);
    scene.points[0].now.p_C0.z() = -1.0;
    scene.points[1].then.p_C0.x() = std::nan("");
    scene.points[2].now.p_C0.z() = 0.0;
    REQUIRE(ok(estimate_stereo_motion(scene.points, scene.T_B_C, q, config, m)));
    CHECK(m.inliers <= 37);
    CHECK(m.inliers > 30);
    std::mt19937 rng(1);
    std::uniform_real_distribution<double> uniform(-3.0, 3.0);
    for (StereoPoint& point : scene.points) {
        point.now.p_C0 = {uniform(rng), uniform(rng), 4.0 + uniform(rng)};
    }
    StereoMotionConfig tight = config;
    tight.rotation_sigma_rad = 1e-3;
    CHECK(estimate_stereo_motion(scene.points, scene.T_B_C, q, tight, m) == Status::kDegenerate);
    const Scene many(700, 0, 1.0, 4);
    test::AllocationGuard guard;
    const Status status = estimate_stereo_motion(many.points, many.T_B_C, many.T_Bi_Bj.q, config, m);
    const std::uint64_t allocations = guard.allocations();
    CHECK(ok(status));
    CHECK(allocations == 0);
    CHECK(m.inliers <= 512);
}

TEST_CASE("the stereo motion config is validated field by field") { test::check_fields(kStereoMotionFields); }

}  // namespace facet
