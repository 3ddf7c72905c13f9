// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/point_grid.h"

#include <catch2/catch.hpp>
#include <memory>
#include <random>
#include <vector>

namespace facet::point_grid_test {
namespace {

TEST_CASE("a point is near exactly when one of all points is, also across cells and outside the image") {
    const auto grid = std::make_unique<PointGrid>();
    std::mt19937 random(4);
    std::uniform_real_distribution<float> u(-40.0F, 800.0F);
    std::uniform_real_distribution<float> v(-40.0F, 520.0F);
    for (const double distance : {3.0, 12.0, 25.0}) {
        grid->clear(distance, 752, 480);
        std::vector<Eigen::Vector2f> points;
        for (int i = 0; i < 200; ++i) {
            const float x = u(random);
            points.emplace_back(x, v(random));
            grid->add(points.back());
        }
        int near = 0;
        for (int i = 0; i < 2000; ++i) {
            const float x = u(random);
            const Eigen::Vector2f p(x, v(random));
            bool expected = false;
            for (const Eigen::Vector2f& q : points) {
                expected = expected || (q - p).squaredNorm() < static_cast<float>(distance * distance);
            }
            REQUIRE(grid->has_near(p) == expected);
            near += expected ? 1 : 0;
        }
        CHECK(near > 10);
        CHECK(near < 1500);
    }
    grid->clear(0.0, 752, 480);
    grid->add({10.0F, 10.0F});
    CHECK_FALSE(grid->has_near({10.0F, 10.0F}));  // nothing is nearer than 0
}

}  // namespace
}  // namespace facet::point_grid_test
