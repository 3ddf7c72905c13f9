// SPDX-License-Identifier: BSD-2-Clause
// The predicates against long integers.
#include "mesh/predicates.h"

#include <boost/multiprecision/cpp_int.hpp>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

namespace facet::predicates_test {
namespace {

using Integer = boost::multiprecision::int1024_t;
using Eigen::Vector2d;

int sign(double x) { return x > 0.0 ? 1 : x < 0.0 ? -1 : 0; }

/// x * 2^200: exact for every double of magnitude 2^-140 and above.
Integer integer(double x) {
    int exponent = 0;
    const auto mantissa = static_cast<long long>(std::ldexp(std::frexp(x, &exponent), 53));
    return Integer(mantissa) << (exponent - 53 + 200);
}

int oracle_orientation(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
    const Integer cx = integer(c.x());
    const Integer cy = integer(c.y());
    const Integer det = (integer(a.x()) - cx) * (integer(b.y()) - cy) - (integer(a.y()) - cy) * (integer(b.x()) - cx);
    return det.sign();
}

int oracle_in_circle(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d) {
    const Vector2d p[3] = {a, b, c};
    Integer x[3];
    Integer y[3];
    Integer lift[3];
    for (int i = 0; i < 3; ++i) {
        x[i] = integer(p[i].x()) - integer(d.x());
        y[i] = integer(p[i].y()) - integer(d.y());
        lift[i] = x[i] * x[i] + y[i] * y[i];
    }
    const Integer det = lift[0] * (x[1] * y[2] - x[2] * y[1]) + lift[1] * (x[2] * y[0] - x[0] * y[2]) +
                        lift[2] * (x[0] * y[1] - x[1] * y[0]);
    return det.sign();
}

/// Moves each coordinate by up to two units in the last place.
Vector2d nudge(Vector2d p, std::mt19937& random) {
    for (int k = 0; k < 2; ++k) {
        const int steps = static_cast<int>(random() % 5) - 2;
        for (int i = 0; i < std::abs(steps); ++i) {
            p[k] = std::nextafter(p[k], steps > 0 ? 1e9 : -1e9);
        }
    }
    return p;
}

TEST_CASE("orientation has the exact sign for points almost on a line") {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform(-1000.0, 1000.0);
    int undecided = 0;  // where the plain determinant has the wrong sign: the test must reach the exact part
    for (int i = 0; i < 20000; ++i) {
        const Vector2d a(uniform(random), uniform(random));
        const Vector2d b(uniform(random), uniform(random));
        const Vector2d on_line = a + (uniform(random) / 500.0) * (b - a);
        const Vector2d c = i % 2 == 0 ? nudge(on_line, random) : on_line;
        const int truth = oracle_orientation(a, b, c);
        REQUIRE(sign(orientation(a, b, c)) == truth);
        REQUIRE(sign(orientation(b, c, a)) == truth);
        REQUIRE(sign(orientation(b, a, c)) == -truth);
        const double plain = (a.x() - c.x()) * (b.y() - c.y()) - (a.y() - c.y()) * (b.x() - c.x());
        undecided += sign(plain) != truth ? 1 : 0;
    }
    CHECK(undecided > 100);
    CHECK(orientation({0.0, 0.0}, {1.0, 1.0}, {7.0, 7.0}) == 0.0);
    CHECK(orientation({0.1, 0.1}, {0.3, 0.3}, {1e-30, 1e-30}) == 0.0);
}

TEST_CASE("in_circle has the exact sign for points almost on a circle") {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    int undecided = 0;
    for (int i = 0; i < 5000; ++i) {
        const Vector2d centre(100.0 * uniform(random), 100.0 * uniform(random));
        const double radius = 300.0 * (1.001 + uniform(random));
        Vector2d p[4];
        for (int k = 0; k < 4; ++k) {
            const double angle = 1.5 * k + uniform(random) / 2.0;
            p[k] = nudge(centre + radius * Vector2d(std::cos(angle), std::sin(angle)), random);
        }
        const int truth = oracle_in_circle(p[0], p[1], p[2], p[3]);
        REQUIRE(sign(in_circle(p[0], p[1], p[2], p[3])) == truth);
        REQUIRE(sign(in_circle(p[1], p[2], p[0], p[3])) == truth);
        REQUIRE(sign(in_circle(p[1], p[0], p[2], p[3])) == -truth);
        undecided += std::abs(in_circle(p[0], p[1], p[2], p[3])) < 1e-3 ? 1 : 0;
    }
    CHECK(undecided > 1000);
}

TEST_CASE("in_circle is zero on grids, and exact for coordinates of very different size") {
    for (const double step : {1.0, 0.1, 1e-3, 1e6}) {
        const Vector2d o(3.0 * step, 5.0 * step);
        const Vector2d a = o;
        const Vector2d b(4.0 * step, 5.0 * step);
        const Vector2d c(4.0 * step, 6.0 * step);
        const Vector2d d(3.0 * step, 6.0 * step);
        CHECK(sign(in_circle(a, b, c, d)) == oracle_in_circle(a, b, c, d));
    }
    CHECK(in_circle({0.0, 0.0}, {2.0, 0.0}, {2.0, 2.0}, {0.0, 2.0}) == 0.0);
    CHECK(in_circle({0.0, 0.0}, {2.0, 0.0}, {2.0, 2.0}, {0.0, 0.0}) == 0.0);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> mantissa(-1.0, 1.0);
    for (int i = 0; i < 3000; ++i) {
        Vector2d p[4];
        for (Vector2d& q : p) {
            q = {std::ldexp(mantissa(random), static_cast<int>(random() % 80) - 40),
                 std::ldexp(mantissa(random), static_cast<int>(random() % 80) - 40)};
        }
        REQUIRE(sign(in_circle(p[0], p[1], p[2], p[3])) == oracle_in_circle(p[0], p[1], p[2], p[3]));
        REQUIRE(sign(orientation(p[0], p[1], p[2])) == oracle_orientation(p[0], p[1], p[2]));
    }
}

}  // namespace
}  // namespace facet::predicates_test
