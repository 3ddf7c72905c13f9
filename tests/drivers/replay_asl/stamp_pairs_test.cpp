// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/replay_asl/stamp_pairs.h"

#include <catch2/catch.hpp>
#include <string>

namespace facet::stamp_pairs_test {
namespace {

/// Stamps in milliseconds.
std::vector<Timestamp> at(std::initializer_list<double> times_ms) {
    std::vector<Timestamp> stamps;
    for (const double t : times_ms) {
        stamps.push_back(Timestamp{} + Duration::from_seconds(1e-3 * t));
    }
    return stamps;
}

/// One letter a frame: T together, A apart, L left only, R right only, S surplus.
std::string kinds(const std::vector<Timestamp>& left, const std::vector<Timestamp>& right) {
    std::string letters;
    for (const StampPair& pair : pair_stamps(left, right, Duration::from_seconds(1e-3))) {
        letters += "TALRS"[static_cast<int>(pair.kind)];
        CHECK((pair.left == StampPair::kNone) == (letters.back() == 'R' || letters.back() == 'S'));
        CHECK((pair.right == StampPair::kNone) == (letters.back() == 'L'));
    }
    return letters;
}

TEST_CASE("rows are paired within the tolerance, then within half a period as apart") {
    const auto left = at({0, 50, 100, 150});
    CHECK(kinds(left, at({0, 51, 99, 150})) == "TTTT");
    CHECK(kinds(left, at({1.1, 52, 105, 174})) == "AAAA");
    CHECK(kinds(left, at({-24, 26, 76, 126})) == "AAAA");
    CHECK(kinds(left, at({0, 49, 101.5, 150})) == "TTAT");
}

TEST_CASE("a row is alone where the other camera has none, and a surplus one beside a pair is named") {
    CHECK(kinds(at({0, 50, 100, 150}), at({0, 100, 150})) == "TLTT");
    CHECK(kinds(at({0, 50, 150, 200}), at({0, 50, 100, 150, 200})) == "TTRTT");
    CHECK(kinds(at({0, 50, 150, 200}), at({5, 55, 105, 155, 205})) == "AARAA");
    CHECK(kinds(at({0, 50, 100, 150}), at({0, 50, 60, 100, 150})) == "TTSTT");
    CHECK(kinds(at({0, 50, 100}), {}) == "LLL");
    CHECK(kinds(at({0}), at({0, 50, 100})) == "TRR");
    CHECK(kinds({}, at({0, 50})) == "RR");
}

TEST_CASE("cameras that run freely drift from together to apart") {
    CHECK(kinds(at({0, 50, 100, 150, 200}), at({0, 50.5, 101, 151.5, 202})) == "TTTAA");
}

TEST_CASE("skews have their median and their range") {
    std::vector<Duration> skews{{5}, {-3}, {4}};
    const StampSkew skew = summarize_skews(skews);
    CHECK(skew.count == 3);
    CHECK(skew.median.ns == 4);
    CHECK(skew.least.ns == -3);
    CHECK(skew.most.ns == 5);
    CHECK(summarize_skews({}).count == 0);
}

}  // namespace
}  // namespace facet::stamp_pairs_test
