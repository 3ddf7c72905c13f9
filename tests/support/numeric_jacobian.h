// SPDX-License-Identifier: BSD-2-Clause
// Numeric differentiation for tests of analytic Jacobians: central differences, plain or on a manifold.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

namespace facet::test {

/// Jacobian of f: R^n -> R^m at x by central differences,
///   column k = (f(x + h_k e_k) - f(x - h_k e_k)) / (2 h_k),  h_k = step * max(1, |x_k|)
/// with f returning an Eigen vector (fixed or dynamic) and x a column vector. Usual error with step 1e-6 and values
/// near one: 1e-9.
/// On a manifold, differentiate the tangent instead: f = [&](const Vector6d& d) { return residual(T.box_plus(d)); } at
/// x = 0.
template <class Function, class Derived>
Eigen::MatrixXd numeric_jacobian(const Function& f, const Eigen::MatrixBase<Derived>& x, double step = 1e-6) {
    using Vector = typename Derived::PlainObject;
    static_assert(Derived::ColsAtCompileTime == 1, "x must be a column vector");
    Eigen::MatrixXd jacobian;
    for (Eigen::Index k = 0; k < x.size(); ++k) {
        const double h = step * std::max(1.0, std::abs(static_cast<double>(x(k))));
        Vector plus = x;
        Vector minus = x;
        plus(k) += h;
        minus(k) -= h;
        const Eigen::VectorXd column = (f(plus) - f(minus)) / (2.0 * h);
        if (k == 0) {
            jacobian.resize(column.size(), x.size());
        }
        REQUIRE(column.size() == jacobian.rows());
        jacobian.col(k) = column;
    }
    return jacobian;
}

/// Checks every entry: |analytic - numeric| <= tolerance * max(1, largest |numeric|). Reports both matrices and the
/// worst entry on failure. A Jacobian with a NaN, or of another shape, fails.
template <class DerivedA, class DerivedB>
void expect_jacobian_near(const Eigen::MatrixBase<DerivedA>& analytic, const Eigen::MatrixBase<DerivedB>& numeric,
                          double tolerance = 1e-6) {
    REQUIRE(analytic.rows() == numeric.rows());
    REQUIRE(analytic.cols() == numeric.cols());
    Eigen::Index row = 0;
    Eigen::Index col = 0;
    const double worst = (analytic - numeric).cwiseAbs().maxCoeff(&row, &col);
    const double scale = std::max(1.0, numeric.cwiseAbs().maxCoeff());
    INFO("analytic:\n" << analytic << "\nnumeric:\n" << numeric << "\nworst entry (" << row << ", " << col << ")");
    CHECK((analytic.allFinite() && numeric.allFinite()));
    CHECK(worst <= tolerance * scale);
}

/// Both in one: compares `analytic` with the central differences of f at x.
template <class DerivedA, class Function, class DerivedX>
void expect_jacobian_near(const Eigen::MatrixBase<DerivedA>& analytic, const Function& f,
                          const Eigen::MatrixBase<DerivedX>& x, double tolerance = 1e-6, double step = 1e-6) {
    expect_jacobian_near(analytic, numeric_jacobian(f, x, step), tolerance);
}

}  // namespace facet::test
