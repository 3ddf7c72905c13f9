// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/acceleration.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace facet;

namespace {

using Vector = Acceleration<2>::Vector;

/// Steps until within 1e-4 of the fixed point of a linear iteration with these rates, counted from 1 px off along both.
int steps(const Vector& rates, bool accelerated) {
    const Vector fixed(3.0F, -1.0F);
    Acceleration<2> acceleration;
    Vector x = fixed + Vector(1.0F, 0.4F);
    int count = 0;
    for (; (x - fixed).norm() > 1e-4F && count < 1000; ++count) {
        const Vector f = (rates.array() - 1.0F) * (x - fixed).array();
        x = accelerated ? acceleration.next(x, f) : Vector(x + f);
    }
    return count;
}

}  // namespace

TEST_CASE("an accelerated iteration takes one rate in two steps, and two rates in fewer", "[frontend]") {
    for (const float rate : {0.7F, 0.4F, -0.3F}) {
        CAPTURE(rate);
        CHECK(steps({rate, rate}, true) == 2);
        CHECK(steps({rate, rate}, false) > 7);
    }
    CHECK(steps({0.5F, 0.05F}, true) <= steps({0.5F, 0.05F}, false) / 2);
    // Beyond the bounds it still converges.
    CHECK(steps({0.95F, 0.9F}, true) < steps({0.95F, 0.9F}, false));
    CHECK(steps({-0.8F, -0.8F}, true) < steps({-0.8F, -0.8F}, false));
}

TEST_CASE("an accelerated iteration at its fixed point stays there", "[frontend]") {
    Acceleration<2> acceleration;
    const Vector x(1.0F, 2.0F);
    CHECK(acceleration.next(x, Vector::Zero()) == x);
    CHECK(acceleration.next(x, Vector::Zero()) == x);
}
