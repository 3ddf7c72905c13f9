// SPDX-License-Identifier: BSD-2-Clause
// The median of a histogram of squares against the exact one.
#include "estimator/geometry/square_histogram.h"

#include <catch2/catch.hpp>
#include <limits>
#include <random>
#include <vector>

namespace facet::square_histogram_test {

TEST_CASE("the median of squares is right to a few percent, at any scale", "[square_histogram]") {
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    for (const double sigma : {1e-3, 0.07, 0.5, 40.0}) {
        SquareHistogram histogram;
        std::vector<double> squares;
        for (int i = 0; i < 5001; ++i) {
            const double x = sigma * normal(random);
            squares.push_back(x * x);
            histogram.add(x * x);
        }
        std::nth_element(squares.begin(), squares.begin() + 2500, squares.end());
        CHECK(histogram.count() == 5001);
        CHECK(histogram.median() == Approx(squares[2500]).epsilon(0.03));
    }
}

TEST_CASE("a minority of any size does not move the median far", "[square_histogram]") {
    SquareHistogram histogram;
    for (int i = 0; i < 700; ++i) {
        histogram.add(1.0 + 1e-3 * i);
    }
    const double alone = histogram.median();
    for (int i = 0; i < 300; ++i) {
        histogram.add(1e9);
    }
    CHECK(histogram.median() < 1.2 * alone);
}

TEST_CASE("a histogram of squares survives whatever comes", "[square_histogram]") {
    SquareHistogram histogram;
    CHECK(histogram.median() == 0.0);
    for (const double square :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -1.0}) {
        histogram.add(square);
    }
    CHECK(histogram.count() == 0);
    histogram.add(0.0);
    histogram.add(std::numeric_limits<double>::denorm_min());
    CHECK(histogram.median() < 1e-6);
    histogram.add(1e300);
    histogram.add(1e300);
    histogram.add(1e300);
    CHECK(histogram.median() > 1e4);
    histogram.clear();
    CHECK(histogram.count() == 0);
}

}  // namespace facet::square_histogram_test
