// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/plane_pairs.h"

#include <Eigen/Cholesky>
#include <catch2/catch.hpp>
#include <memory>
#include <numbers>

using namespace facet;

namespace {

WindowPlane make_plane(PlaneKind kind, const Eigen::Vector3d& normal, int constraints = 50) {
    WindowPlane plane;
    plane.kind = kind;
    plane.plane = plane.plane_lin = Plane::from(normal.normalized(), 1.0, Eigen::Vector3d::Zero());
    plane.constraints = constraints;
    return plane;
}

/// Unit normal of a wall at this azimuth.
Eigen::Vector3d azimuth(double deg) {
    const double a = deg * std::numbers::pi / 180.0;
    return {std::cos(a), std::sin(a), 0.0};
}

PlanePairs find(const WindowPlanes& planes, const RegularityConfig& config, PlanePairs pairs = {}) {
    find_plane_pairs(planes, config, pairs);
    return pairs;
}

}  // namespace

TEST_CASE("plane pairs: nearly parallel and orthogonal walls are found, others not", "[plane_pairs]") {
    RegularityConfig config;
    config.use_gravity = false;
    WindowPlanes planes;
    planes.push_back(make_plane(PlaneKind::kVertical, azimuth(0.0)));
    planes.push_back(make_plane(PlaneKind::kVertical, azimuth(92.0)));
    planes.push_back(make_plane(PlaneKind::kVertical, azimuth(178.0)));
    planes.push_back(make_plane(PlaneKind::kVertical, azimuth(45.0)));
    const PlanePairs pairs = find(planes, config);
    REQUIRE(pairs.size() == 2);  // 92 to 178 differ by 86: outside the gate
    CHECK(pairs[0] == PlanePair{1, 0, false});
    CHECK(pairs[1] == PlanePair{2, 0, true});
}

TEST_CASE("plane pairs: a pair stays longer than it takes to become one", "[plane_pairs]") {
    RegularityConfig config;
    config.use_gravity = false;
    WindowPlanes planes;
    planes.push_back(make_plane(PlaneKind::kVertical, azimuth(0.0)));
    planes.push_back(make_plane(PlaneKind::kVertical, azimuth(94.0)));
    CHECK(find(planes, config).empty());
    CHECK(find(planes, config, {{1, 0, false}}).size() == 1);
    planes[1] = make_plane(PlaneKind::kVertical, azimuth(95.0));
    CHECK(find(planes, config, {{1, 0, false}}).empty());
}

TEST_CASE("plane pairs: slanted planes are held by their landmarks alone", "[plane_pairs]") {
    WindowPlanes planes;
    planes.push_back(make_plane(PlaneKind::kSlanted, {0.06, 0.0, 1.0}));
    planes.push_back(make_plane(PlaneKind::kSlanted, {0.06, 0.0, 1.0}));
    planes.push_back(make_plane(PlaneKind::kVertical, {0.0, 1.0, 0.0}));
    const PlanePairs pairs = find(planes, {});
    REQUIRE(pairs.size() == 1);
    CHECK(pairs[0] == PlanePair{2, PlanePair::kVertical, false});
}

TEST_CASE("plane pairs: gravity levels floors and stands walls upright", "[plane_pairs]") {
    RegularityConfig config;
    WindowPlanes planes;
    planes.push_back(make_plane(PlaneKind::kHorizontal, {0.02, 0.0, 1.0}));
    planes.push_back(make_plane(PlaneKind::kVertical, {1.0, 0.0, 0.03}));
    planes.push_back(make_plane(PlaneKind::kVertical, {0.0, 1.0, 0.2}));       // 11 degrees: a slope
    planes.push_back(make_plane(PlaneKind::kHorizontal, {0.0, 0.0, 1.0}, 5));  // too few landmarks
    PlanePairs pairs = find(planes, config);
    CHECK(std::count(pairs.begin(), pairs.end(), PlanePair{0, PlanePair::kVertical, true}) == 1);
    CHECK(std::count(pairs.begin(), pairs.end(), PlanePair{1, PlanePair::kVertical, false}) == 1);
    CHECK(std::none_of(pairs.begin(), pairs.end(), [](const PlanePair& p) { return p.a == 3 || p.b == 3; }));
    CHECK(std::none_of(pairs.begin(), pairs.end(), [](const PlanePair& p) { return p.a == 2 && p.b < 0; }));

    SECTION("and the terms bring them there") {
        const auto system = std::make_unique<ReducedSystem>();
        constexpr int kFirst = 1;
        double cost = 0.0;
        for (int iteration = 0; iteration < 5; ++iteration) {
            system->reset(1, kFirst + kPlaneDim * static_cast<int>(planes.size()));
            cost = add_plane_pairs(planes, pairs, kFirst, *system);
            Eigen::MatrixXd h = system->h().selfadjointView<Eigen::Lower>();
            h.diagonal().array() += 1e-6;
            const Eigen::VectorXd step = h.ldlt().solve(-Eigen::VectorXd(system->g()));
            for (std::size_t p = 0; p < planes.size(); ++p) {
                planes[p].plane = planes[p].plane.box_plus(step.segment<3>(kFirst + kPlaneDim * static_cast<int>(p)));
            }
        }
        CHECK(cost < 1e-6);
        CHECK(planes[0].plane.normal_W().head<2>().norm() < 1e-4);
        CHECK(std::abs(planes[1].plane.normal_W().z()) < 1e-4);
        CHECK(planes[2].plane.normal_W().z() == Approx(0.2 / std::hypot(1.0, 0.2)).margin(1e-3));
    }
}

namespace {

/// Tilt (deg) at which a floor comes to rest that landmarks show at `seen_deg` from level, known to `sigma_deg`.
double tilt_at_rest(double seen_deg, double sigma_deg) {
    constexpr double kRad = std::numbers::pi / 180.0;
    const WindowPlane seen =
        make_plane(PlaneKind::kHorizontal, {std::sin(seen_deg * kRad), 0.0, std::cos(seen_deg * kRad)});
    WindowPlanes planes;
    planes.push_back(seen);
    const PlanePairs pairs{{0, PlanePair::kVertical, true}};
    const auto system = std::make_unique<ReducedSystem>();
    const double information = 1.0 / std::pow(sigma_deg * kRad, 2);
    for (int iteration = 0; iteration < 50; ++iteration) {
        planes[0].plane_lin = planes[0].plane;
        system->reset(1, kPlaneDim);
        add_plane_pairs(planes, pairs, 0, *system);
        Eigen::Matrix3d h = system->h().topLeftCorner<3, 3>().selfadjointView<Eigen::Lower>();
        h.diagonal().array() += information;
        const Eigen::Vector3d pull = information * planes[0].plane.box_minus_to(seen.plane);
        planes[0].plane = planes[0].plane.box_plus(h.ldlt().solve(pull - system->g().head<3>()));
    }
    return std::acos(std::min(1.0, planes[0].plane.normal_W().z())) / kRad;
}

}  // namespace

TEST_CASE("plane pairs: a floor is held level only as far as its landmarks agree", "[plane_pairs]") {
    CHECK(tilt_at_rest(0.2, 0.6) < 0.07);  // little known: the prior of buildings
    CHECK(tilt_at_rest(0.2, 0.03) > 0.19);
    CHECK(tilt_at_rest(2.0, 0.1) > 1.97);  // a ramp is left alone
    CHECK(tilt_at_rest(2.0, 0.3) > 1.8);
}

TEST_CASE("plane pairs can be switched off", "[plane_pairs]") {
    RegularityConfig config;
    config.use_pairs = config.use_gravity = false;
    WindowPlanes planes;
    planes.push_back(make_plane(PlaneKind::kHorizontal, {0.0, 0.0, 1.0}));
    planes.push_back(make_plane(PlaneKind::kVertical, azimuth(0.0)));
    planes.push_back(make_plane(PlaneKind::kVertical, azimuth(90.0)));
    CHECK(find(planes, config).empty());
}
