// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/plane_gravity.h"

#include <Eigen/Cholesky>
#include <catch2/catch.hpp>
#include <memory>
#include <numbers>

namespace facet::plane_gravity_test {
namespace {

constexpr double kRad = std::numbers::pi / 180.0;

WindowPlane make_plane(PlaneKind kind, const Eigen::Vector3d& normal, int constraints = 50) {
    WindowPlane plane;
    plane.kind = kind;
    plane.plane = plane.plane_lin = Plane::from(normal.normalized(), 1.0, Eigen::Vector3d::Zero());
    plane.constraints = constraints;
    return plane;
}

WindowPlanes aligned(WindowPlanes planes, const RegularityConfig& config = {}) {
    align_planes(config, planes);
    return planes;
}

}  // namespace

TEST_CASE("a plane stays aligned longer than it takes to become so", "[plane_gravity]") {
    WindowPlanes planes;
    planes.push_back(make_plane(PlaneKind::kVertical, {1.0, 0.0, std::tan(4.0 * kRad)}));
    CHECK_FALSE(aligned(planes)[0].is_aligned);
    planes[0].is_aligned = true;
    CHECK(aligned(planes)[0].is_aligned);
    planes[0].plane = Plane::from(Eigen::Vector3d(1.0, 0.0, std::tan(5.0 * kRad)).normalized(), 1.0, {});
    CHECK_FALSE(aligned(planes)[0].is_aligned);
}

TEST_CASE("slanted planes are held by their landmarks alone", "[plane_gravity]") {
    WindowPlanes planes;
    planes.push_back(make_plane(PlaneKind::kSlanted, {0.01, 0.0, 1.0}));
    CHECK_FALSE(aligned(planes)[0].is_aligned);
}

TEST_CASE("gravity levels floors and stands walls upright", "[plane_gravity]") {
    WindowPlanes planes;
    planes.push_back(make_plane(PlaneKind::kHorizontal, {0.02, 0.0, 1.0}));
    planes.push_back(make_plane(PlaneKind::kVertical, {1.0, 0.0, 0.03}));
    planes.push_back(make_plane(PlaneKind::kVertical, {0.0, 1.0, 0.2}));       // 11 degrees: a slope
    planes.push_back(make_plane(PlaneKind::kHorizontal, {0.0, 0.0, 1.0}, 5));  // too few landmarks
    align_planes({}, planes);
    CHECK(planes[0].is_aligned);
    CHECK(planes[1].is_aligned);
    CHECK_FALSE(planes[2].is_aligned);
    CHECK_FALSE(planes[3].is_aligned);

    SECTION("and the terms bring them there") {
        const auto system = std::make_unique<ReducedSystem>();
        constexpr int kFirst = 1;
        double cost = 0.0;
        for (int iteration = 0; iteration < 5; ++iteration) {
            system->reset(1, kFirst + kPlaneDim * static_cast<int>(planes.size()));
            cost = add_plane_gravity(planes, kFirst, *system);
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
    const WindowPlane seen =
        make_plane(PlaneKind::kHorizontal, {std::sin(seen_deg * kRad), 0.0, std::cos(seen_deg * kRad)});
    WindowPlanes planes;
    planes.push_back(seen);
    planes[0].is_aligned = true;
    const auto system = std::make_unique<ReducedSystem>();
    const double information = 1.0 / std::pow(sigma_deg * kRad, 2);
    for (int iteration = 0; iteration < 50; ++iteration) {
        planes[0].plane_lin = planes[0].plane;
        system->reset(1, kPlaneDim);
        add_plane_gravity(planes, 0, *system);
        Eigen::Matrix3d h = system->h().topLeftCorner<3, 3>().selfadjointView<Eigen::Lower>();
        h.diagonal().array() += information;
        const Eigen::Vector3d pull = information * planes[0].plane.box_minus_to(seen.plane);
        planes[0].plane = planes[0].plane.box_plus(h.ldlt().solve(pull - system->g().head<3>()));
    }
    return std::acos(std::min(1.0, planes[0].plane.normal_W().z())) / kRad;
}

}  // namespace

TEST_CASE("a floor is held level only as far as its landmarks agree", "[plane_gravity]") {
    CHECK(tilt_at_rest(0.2, 0.6) < 0.07);  // little known: the prior of buildings
    CHECK(tilt_at_rest(0.2, 0.03) > 0.19);
    CHECK(tilt_at_rest(2.0, 0.1) > 1.97);  // a ramp is left alone
    CHECK(tilt_at_rest(2.0, 0.3) > 1.8);
}

TEST_CASE("planes are aligned only if configured", "[plane_gravity]") {
    RegularityConfig config;
    config.use_gravity = false;
    WindowPlanes planes;
    planes.push_back(make_plane(PlaneKind::kHorizontal, {0.0, 0.0, 1.0}));
    planes.push_back(make_plane(PlaneKind::kVertical, {1.0, 0.0, 0.0}));
    for (const WindowPlane& plane : aligned(planes, config)) {
        CHECK_FALSE(plane.is_aligned);
    }
}

}  // namespace facet::plane_gravity_test
