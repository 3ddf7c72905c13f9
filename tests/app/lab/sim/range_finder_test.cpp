// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/sim/range_finder.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/app/lab/sim/draft_scene.h"

namespace facet::range_finder_test {

using namespace facet::sim;

namespace {

/// A second of standing in the air with the body's x axis up, as an inertial sensor may be mounted.
std::vector<ImuRecord> still_records(const Scene& scene) {
    std::vector<ImuRecord> records(201);
    for (std::size_t i = 0; i < records.size(); ++i) {
        records[i].t_s = 0.005 * static_cast<double>(i);
        records[i].sample.stamp = {static_cast<std::int64_t>(i) * 5'000'000};
        records[i].state.T_W_B.p = scene.flight_volume().start;
        records[i].state.T_W_B.q = Eigen::AngleAxisd(-M_PI / 2.0, Eigen::Vector3d::UnitY());
    }
    return records;
}

}  // namespace

TEST_CASE("a range finder reads the distance to what is below, along the body's axis that looks down") {
    const Scene& scene = draft_scene("room");
    const std::vector<ImuRecord> records = still_records(scene);
    const double truth_m = scene.cast(scene.flight_volume().start, -Eigen::Vector3d::UnitZ()).distance;
    const auto exact = find_ranges(scene, records, 0.0, 1);
    REQUIRE(exact.size() == 51);
    for (const RangeSample& sample : exact) {
        CHECK((sample.p_B - Eigen::Vector3d(-truth_m, 0.0, 0.0)).norm() < 1e-9);
    }
    const auto noisy = find_ranges(scene, records, 0.05, 1);
    double sum_m2 = 0.0;
    for (const RangeSample& sample : noisy) {
        sum_m2 += std::pow(sample.p_B.norm() - truth_m, 2);
    }
    CHECK(std::sqrt(sum_m2 / static_cast<double>(noisy.size())) == Approx(0.05).epsilon(0.3));
}

}  // namespace facet::range_finder_test
