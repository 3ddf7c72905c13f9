// SPDX-License-Identifier: BSD-2-Clause
#include "app/support/statistics.h"

#include <catch2/catch.hpp>

namespace facet::statistics_test {
namespace {

/// n, n-1, ... 1: the sample of rank r is r + 1.
std::vector<double> descending(int n) {
    std::vector<double> samples;
    for (int i = n; i >= 1; --i) {
        samples.push_back(i);
    }
    return samples;
}

TEST_CASE("samples are sorted and counted") {
    const OrderStatistics s({3.0, -1.0, 2.0, 2.0});
    CHECK(s.count() == 4);
    CHECK(std::vector<double>(s.sorted().begin(), s.sorted().end()) == std::vector<double>{-1.0, 2.0, 2.0, 3.0});
    CHECK(s.max() == 3.0);
}

TEST_CASE("the medians of an odd number of samples are the middle one") {
    const OrderStatistics s(descending(5));
    CHECK(s.median() == 3.0);
    CHECK(s.upper_median() == 3.0);
    CHECK(s.quantile(0.5) == 3.0);
    CHECK(s.nearest_rank(0.5) == 3.0);
}

TEST_CASE("the medians of an even number of samples differ as documented") {
    const OrderStatistics s(descending(6));
    CHECK(s.median() == 3.5);
    CHECK(s.upper_median() == 4.0);
    CHECK(s.quantile(0.5) == 3.0);
    CHECK(s.nearest_rank(0.5) == 3.0);
}

TEST_CASE("quantiles go from the smallest to the largest sample") {
    const OrderStatistics s(descending(200));
    CHECK(s.quantile(0.0) == 1.0);
    CHECK(s.quantile(0.9) == 180.0);  // rank floor(179.1)
    CHECK(s.quantile(1.0) == 200.0);
    CHECK(s.nearest_rank(1e-9) == 1.0);
    CHECK(s.nearest_rank(0.99) == 198.0);
    CHECK(s.nearest_rank(1.0) == 200.0);
    // Where the two definitions disagree.
    CHECK(OrderStatistics(descending(150)).quantile(0.99) == 148.0);
    CHECK(OrderStatistics(descending(150)).nearest_rank(0.99) == 149.0);
}

TEST_CASE("one sample is every statistic of itself, and no sample gives zero") {
    const OrderStatistics one({-2.5});
    const OrderStatistics none({});
    for (const auto& [s, expected] : {std::pair{&one, -2.5}, std::pair{&none, 0.0}}) {
        CHECK(s->median() == expected);
        CHECK(s->upper_median() == expected);
        CHECK(s->quantile(0.9) == expected);
        CHECK(s->nearest_rank(0.99) == expected);
        CHECK(s->max() == expected);
    }
    CHECK(none.count() == 0);
}

}  // namespace
}  // namespace facet::statistics_test
