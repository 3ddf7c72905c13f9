// SPDX-License-Identifier: BSD-2-Clause
// Invariants of SO(3): exponential and logarithm near 0 and pi, right Jacobian and its inverse.
#include "estimator/geometry/so3.h"

#include <catch2/catch.hpp>
#include <random>
#include <unsupported/Eigen/MatrixFunctions>
#include <vector>

#include "tests/support/numeric_jacobian.h"

namespace facet::so3_test {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// Unit vectors: the axes, and random ones.
std::vector<Eigen::Vector3d> axes() {
    std::mt19937 rng(7);
    std::normal_distribution<double> normal;
    std::vector<Eigen::Vector3d> out{Eigen::Vector3d::UnitX(), -Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ()};
    for (int k = 0; k < 5; ++k) {
        out.push_back(Eigen::Vector3d(normal(rng), normal(rng), normal(rng)).normalized());
    }
    return out;
}

}  // namespace

TEST_CASE("skew is the cross product") {
    const Eigen::Vector3d a(1.0, -2.0, 0.5);
    const Eigen::Vector3d b(0.3, 4.0, -1.0);
    CHECK((skew(a) * b - a.cross(b)).norm() < 1e-15);
}

TEST_CASE("exp is the matrix exponential and of unit length") {
    for (const Eigen::Vector3d& axis : axes()) {
        for (const double angle : {0.0, 1e-12, 1e-6, 9.9e-4, 1.01e-3, 0.1, 1.0, 3.0, kPi, 5.0}) {
            CAPTURE(axis.transpose(), angle);
            const Eigen::Quaterniond q = so3_exp(angle * axis);
            const Eigen::Matrix3d reference = skew(angle * axis).exp();
            CHECK(std::abs(q.norm() - 1.0) < 1e-14);
            CHECK((q.toRotationMatrix() - reference).norm() < 2e-14);
        }
    }
}

TEST_CASE("log inverts exp up to pi") {
    for (const Eigen::Vector3d& axis : axes()) {
        for (const double angle :
             {0.0, 1e-300, 1e-12, 1e-8, 1.9e-7, 2.1e-7, 1e-4, 0.1, 1.0, 3.0, kPi - 1e-6, kPi - 1e-10}) {
            CAPTURE(axis.transpose(), angle);
            const Eigen::Vector3d theta = angle * axis;
            CHECK((so3_log(so3_exp(theta)) - theta).norm() <= 1e-14 + 1e-14 * angle);
        }
    }
}

TEST_CASE("log does not depend on the sign of the quaternion and stays within pi") {
    for (const Eigen::Vector3d& axis : axes()) {
        for (const double angle : {1e-9, 0.5, 2.0, 3.1, 3.3, 6.0}) {
            CAPTURE(axis.transpose(), angle);
            const Eigen::Quaterniond q = so3_exp(angle * axis);
            const Eigen::Quaterniond minus(-q.w(), -q.x(), -q.y(), -q.z());
            const Eigen::Vector3d theta = so3_log(q);
            CHECK((theta - so3_log(minus)).norm() < 1e-15);
            CHECK(theta.norm() <= kPi + 1e-15);
            CHECK((so3_exp(theta).toRotationMatrix() - q.toRotationMatrix()).norm() < 1e-14);
        }
    }
    CHECK(so3_log(Eigen::Quaterniond(0.0, 0.0, 1.0, 0.0)).isApprox(Eigen::Vector3d(0.0, kPi, 0.0)));
}

TEST_CASE("right Jacobian matches numeric differentiation") {
    for (const Eigen::Vector3d& axis : axes()) {
        for (const double angle : {0.0, 1e-5, 9.9e-4, 1.01e-3, 0.3, 1.5, 3.0}) {
            CAPTURE(axis.transpose(), angle);
            const Eigen::Vector3d theta = angle * axis;
            const auto f = [&](const Eigen::Vector3d& t) { return so3_log(so3_exp(theta).conjugate() * so3_exp(t)); };
            test::expect_jacobian_near(so3_right_jacobian(theta), f, theta, 1e-8, 1e-5);
        }
    }
}

TEST_CASE("inverse of the right Jacobian is its inverse, also across the Taylor limits") {
    for (const Eigen::Vector3d& axis : axes()) {
        for (const double angle : {0.0, 1e-6, 9.9e-4, 1.01e-3, 9.9e-3, 1.01e-2, 0.3, 1.5, 3.0, kPi - 1e-3}) {
            CAPTURE(axis.transpose(), angle);
            const Eigen::Vector3d theta = angle * axis;
            const Eigen::Matrix3d product = so3_right_jacobian(theta) * so3_right_jacobian_inverse(theta);
            CHECK((product - Eigen::Matrix3d::Identity()).norm() < 1e-10);
        }
    }
}

}  // namespace facet::so3_test
