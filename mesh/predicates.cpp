// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/predicates.h"

#include <array>
#include <cmath>

namespace facet::predicates {
namespace {

/// A number as an exact sum of doubles: not overlapping, of increasing magnitude, without zeros. At most N of them.
template <int N>
struct Expansion {
    std::array<double, N> term;
    int size = 0;

    void append(double t) {
        if (t != 0.0) {
            term[static_cast<std::size_t>(size++)] = t;
        }
    }
    double operator[](int i) const { return term[static_cast<std::size_t>(i)]; }
    /// Sign of the number: that of its largest term.
    double sign() const { return size == 0 ? 0.0 : (*this)[size - 1]; }
};

/// a + b = sum + error exactly.
inline double two_sum(double a, double b, double& error) {
    const double sum = a + b;
    const double b_part = sum - a;
    error = (a - (sum - b_part)) + (b - b_part);
    return sum;
}

/// The same if |a| >= |b| or a = 0.
inline double fast_two_sum(double a, double b, double& error) {
    const double sum = a + b;
    error = b - (sum - a);
    return sum;
}

/// a * b = product + error exactly.
inline double two_product(double a, double b, double& error) {
    const double product = a * b;
    error = std::fma(a, b, -product);
    return product;
}

/// a - b.
Expansion<2> difference(double a, double b) {
    Expansion<2> d;
    double error = 0.0;
    const double head = two_sum(a, -b, error);
    d.append(error);
    d.append(head);
    return d;
}

template <int N>
Expansion<N> operator-(Expansion<N> a) {
    for (int i = 0; i < a.size; ++i) {
        a.term[static_cast<std::size_t>(i)] = -a[i];
    }
    return a;
}

/// Sum of two expansions: their terms merged by magnitude, then swept by two_sum. [Shewchuk97, fig. 8]
template <int N, int M>
Expansion<N + M> operator+(const Expansion<N>& a, const Expansion<M>& b) {
    Expansion<N + M> sum;
    int i = 0;
    int j = 0;
    const auto next = [&] { return j == b.size || (i < a.size && std::abs(a[i]) < std::abs(b[j])) ? a[i++] : b[j++]; };
    const int count = a.size + b.size;
    if (count == 0) {
        return sum;
    }
    double carry = next();
    for (int k = 1; k < count; ++k) {
        double error = 0.0;
        carry = two_sum(carry, next(), error);
        sum.append(error);
    }
    sum.append(carry);
    return sum;
}

/// Product with one double. [Shewchuk97, fig. 13]
template <int N>
Expansion<2 * N> operator*(const Expansion<N>& a, double b) {
    Expansion<2 * N> product;
    if (a.size == 0) {
        return product;
    }
    double error = 0.0;
    double carry = two_product(a[0], b, error);
    product.append(error);
    for (int i = 1; i < a.size; ++i) {
        double low = 0.0;
        const double high = two_product(a[i], b, low);
        carry = two_sum(carry, low, error);
        product.append(error);
        carry = fast_two_sum(high, carry, error);
        product.append(error);
    }
    product.append(carry);
    return product;
}

/// Product of two expansions: one row for each term of b, added up.
template <int N, int M>
Expansion<2 * N * M> operator*(const Expansion<N>& a, const Expansion<M>& b) {
    Expansion<2 * N * M> product;
    for (int j = 0; j < b.size; ++j) {
        const auto sum = product + a * b[j];
        product.size = sum.size;  // never more than 2 N M terms: each row has at most 2 N
        for (int i = 0; i < sum.size; ++i) {
            product.term[static_cast<std::size_t>(i)] = sum[i];
        }
    }
    return product;
}

}  // namespace

double exact_orientation(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
    const auto acx = difference(a.x(), c.x());
    const auto acy = difference(a.y(), c.y());
    const auto bcx = difference(b.x(), c.x());
    const auto bcy = difference(b.y(), c.y());
    return (acx * bcy + -(acy * bcx)).sign();
}

/// The in-circle determinant of differences that are expansions of N terms.
template <int N>
double in_circle_sign(const std::array<Expansion<N>, 3>& x, const std::array<Expansion<N>, 3>& y) {
    const auto part = [&](std::size_t i, std::size_t j, std::size_t k) {
        return (x[j] * y[k] + -(x[k] * y[j])) * (x[i] * x[i] + y[i] * y[i]);
    };
    return ((part(0, 1, 2) + part(1, 2, 0)) + part(2, 0, 1)).sign();
}

double exact_in_circle(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c,
                       const Eigen::Vector2d& d) {
    const std::array<Expansion<2>, 3> x{difference(a.x(), d.x()), difference(b.x(), d.x()), difference(c.x(), d.x())};
    const std::array<Expansion<2>, 3> y{difference(a.y(), d.y()), difference(b.y(), d.y()), difference(c.y(), d.y())};
    // Differences of close numbers are mostly doubles: a shorter computation, and the common case on a grid.
    std::array<Expansion<1>, 3> x1;
    std::array<Expansion<1>, 3> y1;
    for (std::size_t i = 0; i < 3; ++i) {
        if (x[i].size > 1 || y[i].size > 1) {
            return in_circle_sign(x, y);
        }
        x1[i].append(x[i].sign());
        y1[i].append(y[i].sign());
    }
    return in_circle_sign(x1, y1);
}

}  // namespace facet::predicates
