// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/flight/gauge.h"

#include <catch2/catch.hpp>

#include "estimator/geometry/so3.h"

namespace facet::gauge_test {

TEST_CASE("a yaw is uncertain of a place as far away as it is about its origin", "[gauge]") {
    Gauge gauge;
    gauge.origin_W = {1.0, 2.0, 3.0};
    gauge.covariance(0, 0) = 0.01 * 0.01;
    const Gauge away = gauge.about({11.0, 2.0, 7.0});
    CHECK(std::sqrt(away.covariance(2, 2)) == Approx(0.1));  // 10 m along x: sideways
    CHECK(away.covariance(1, 1) < 1e-20);
    CHECK(away.covariance(3, 3) < 1e-20);
    CHECK((away.about(gauge.origin_W).covariance - gauge.covariance).cwiseAbs().maxCoeff() < 1e-18);
}

TEST_CASE("what a state does not know of its yaw and place, in the world", "[gauge]") {
    Belief belief;
    belief.state.q_W_B = so3_exp({0.3, -0.4, 0.9});
    belief.state.p_W_B = {1.0, 2.0, 3.0};
    const Eigen::Vector3d up_B = belief.state.q_W_B.conjugate() * Eigen::Vector3d::UnitZ();
    belief.covariance.block<3, 3>(kTheta, kTheta) = 0.04 * up_B * up_B.transpose();
    belief.covariance.block<3, 3>(kPos, kPos) = Eigen::Vector3d(0.1, 0.2, 0.3).asDiagonal();
    const Gauge gauge = gauge_of(belief);
    CHECK(gauge.origin_W == belief.state.p_W_B);
    CHECK((gauge.covariance.diagonal() - Eigen::Vector4d(0.04, 0.1, 0.2, 0.3)).norm() < 1e-12);
}

TEST_CASE("gauges add up about the newer one's origin", "[gauge]") {
    Gauge sum;
    sum.covariance.diagonal() << 0.0, 1.0, 3.0, 2.0;
    Gauge more;
    more.origin_W = {1.0, 0.0, 0.0};
    more.covariance.diagonal() << 0.0, 3.0, 0.0, 0.0;
    sum.add(more);
    CHECK(sum.origin_W == more.origin_W);
    CHECK((sum.covariance.diagonal() - Eigen::Vector4d(0.0, 4.0, 3.0, 2.0)).norm() < 1e-12);
}

}  // namespace facet::gauge_test
