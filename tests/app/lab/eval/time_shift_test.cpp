// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/time_shift.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "estimator/geometry/so3.h"

namespace facet {
namespace {

Eigen::Vector3d place(double s) { return {2.0 * std::cos(0.5 * s), 1.5 * std::sin(0.7 * s), 0.3 * std::sin(0.9 * s)}; }

Eigen::Quaterniond attitude(double s) {
    return so3_exp(Eigen::Vector3d(0.3 * std::sin(1.3 * s), 0.2 * std::cos(0.8 * s), 0.4 * s));
}

/// A flight whose true positions and orientations are stamped late; the estimate is in a world of its own.
std::vector<PosePair> pairs(double seconds, double positions_late_s, double orientations_late_s) {
    const Se3 T{so3_exp(Eigen::Vector3d(0.1, -0.3, 2.0)), {1.0, 2.0, 3.0}};
    std::vector<PosePair> result;
    for (int i = 0; i <= static_cast<int>(20 * seconds); ++i) {
        const double s = 0.05 * i;
        result.push_back({.stamp = Timestamp{static_cast<std::int64_t>(i) * 50'000'000},
                          .truth = {attitude(s - orientations_late_s), place(s - positions_late_s)},
                          .estimate = T * Se3{attitude(s), place(s)}});
    }
    return result;
}

TEST_CASE("positions and orientations of a ground truth may come late apart from each other") {
    const TimeShift shift = time_shift(pairs(20.0, 0.010, -0.002));
    REQUIRE(shift.is_known);
    CHECK(shift.position_s == Approx(0.010).epsilon(0.01));
    CHECK(shift.orientation_s == Approx(-0.002).epsilon(0.02));
    CHECK(shift.position_rmse_m < 1e-4);  // of 8 mm
}

TEST_CASE("clocks that agree have no shift, and what else is wrong stays an error") {
    std::vector<PosePair> flight = pairs(20.0, 0.0, 0.0);
    for (std::size_t i = 0; i < flight.size(); ++i) {
        flight[i].estimate.p.x() += i % 2 == 0 ? 0.003 : -0.003;
    }
    const TimeShift shift = time_shift(flight);
    REQUIRE(shift.is_known);
    CHECK(std::abs(shift.position_s) < 1e-4);
    CHECK(std::abs(shift.orientation_s) < 1e-4);
    CHECK(shift.position_rmse_m == Approx(0.003).epsilon(0.02));
}

TEST_CASE("a vehicle that stands, or hardly any poses, tell nothing of clocks") {
    CHECK_FALSE(time_shift({}).is_known);
    CHECK_FALSE(time_shift(pairs(0.4, 0.01, 0.0)).is_known);
    std::vector<PosePair> standing = pairs(20.0, 0.0, 0.0);
    for (PosePair& pair : standing) {
        pair.truth = standing.front().truth;
        pair.estimate = standing.front().estimate;
    }
    CHECK_FALSE(time_shift(standing).is_known);
}

}  // namespace
}  // namespace facet
