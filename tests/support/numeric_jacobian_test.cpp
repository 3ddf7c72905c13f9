// SPDX-License-Identifier: BSD-2-Clause
#include "tests/support/numeric_jacobian.h"

#include <catch2/catch.hpp>

namespace facet::test::numeric_jacobian_test {
namespace {

Eigen::Vector2d polar_to_plane(const Eigen::Vector2d& polar) {
    return {polar(0) * std::cos(polar(1)), polar(0) * std::sin(polar(1))};
}

Eigen::Matrix2d d_plane_d_polar(const Eigen::Vector2d& polar) {
    Eigen::Matrix2d d;
    d << std::cos(polar(1)), -polar(0) * std::sin(polar(1)), std::sin(polar(1)), polar(0) * std::cos(polar(1));
    return d;
}

TEST_CASE("central differences match a closed form", "[numeric_jacobian]") {
    const Eigen::Vector2d polar(2.5, 0.7);
    const Eigen::MatrixXd numeric = numeric_jacobian(polar_to_plane, polar);
    REQUIRE((numeric - d_plane_d_polar(polar)).cwiseAbs().maxCoeff() < 1e-8);
    expect_jacobian_near(d_plane_d_polar(polar), polar_to_plane, polar);
}

TEST_CASE("functions of dynamic and other sizes are differentiated", "[numeric_jacobian]") {
    const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(4, -1.0, 1.0);
    Eigen::Matrix<double, 3, 4> a;
    a << 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12;
    expect_jacobian_near(
        a, [&](const Eigen::VectorXd& v) { return Eigen::VectorXd(a * v); }, x);
}

TEST_CASE("rejects a wrong Jacobian", "[numeric_jacobian][!shouldfail]") {
    const Eigen::Vector2d polar(2.5, 0.7);
    Eigen::Matrix2d wrong = d_plane_d_polar(polar);
    wrong(1, 0) += 1e-4;
    expect_jacobian_near(wrong, polar_to_plane, polar);
}

TEST_CASE("rejects NaN", "[numeric_jacobian][!shouldfail]") {
    const Eigen::Vector2d polar(2.5, 0.7);
    Eigen::Matrix2d wrong = d_plane_d_polar(polar);
    wrong(0, 0) = std::nan("");
    expect_jacobian_near(wrong, polar_to_plane, polar);
}

}  // namespace
}  // namespace facet::test::numeric_jacobian_test
