// SPDX-License-Identifier: BSD-2-Clause
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "mesh/places/sighting_fit.h"

namespace facet::sighting_fit_test {
namespace {

constexpr double kPixel = 0.3 / 460.0;

/// A place and a view of the same points, exact but for what is done to the view afterwards.
struct TwoViews {
    PlaceView known;
    PlaceView seen;
    YawPose T_K_G{0.1, {0.4, -0.3, 0.1}};

    TwoViews() {
        Eigen::Matrix3d R_G_C;  // looks along x, level
        R_G_C << 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0;
        known.q_G_C = Eigen::Quaterniond(R_G_C).cast<float>();
        seen.q_G_C = known.q_G_C;
        std::mt19937 random(3);
        std::uniform_real_distribution<double> across(-1.5, 1.5);
        std::uniform_real_distribution<double> ahead(2.5, 4.5);
        for (int i = 0; i < 80; ++i) {
            const Eigen::Vector3d p_K(ahead(random), across(random), across(random));
            PlacePoint point;
            point.depth_sigma = 0.01F;
            point.p_G = p_K.cast<float>();
            known.points.push_back(point);
            point.p_G = (T_K_G.inverse() * p_K).cast<float>();
            seen.points.push_back(point);
        }
    }

    /// The attitude that the view believes it has.
    void tilt(double about_x, double about_y) {
        const Eigen::Quaterniond turn = so3_exp({about_x, about_y, 0.0});
        seen.q_G_C = (turn * seen.q_G_C.cast<double>()).cast<float>();
        for (PlacePoint& point : seen.points) {
            point.p_G = (turn * point.p_G.cast<double>()).cast<float>();
        }
    }
    /// Inverse depths of a view that a wrong calibration gives.
    static void offset(PlaceView& view, double rho) {
        for (PlacePoint& point : view.points) {
            point.p_G /= 1.0F + static_cast<float>(rho) * view.axis_G().dot(point.p_G);
        }
        view.shared_rho_sigma = static_cast<float>(std::abs(rho));
    }

    SightingFit::Result fit(SightingFit::State& state, bool with_depth = true) const {
        SightingFit fit(seen, known, kPixel);
        for (std::size_t i = 0; i < seen.points.size(); ++i) {
            fit.add(i, fit.direction_of(i), with_depth ? std::optional(i) : std::nullopt);
        }
        SightingFit::Result result;
        for (int step = 0; step < 8; ++step) {
            result = fit.step(SightingFit::kAll, state);
        }
        return result;
    }
    double error_m(const SightingFit::State& state) const { return (state.T_K_G.p - T_K_G.p).norm(); }
};

TEST_CASE("exact sightings give the exact pose, with and without the present depths") {
    const TwoViews views;
    for (const bool with_depth : {false, true}) {
        SightingFit::State state;
        const SightingFit::Result result = views.fit(state, with_depth);
        CHECK(views.error_m(state) < 1e-5);
        CHECK(std::abs(state.T_K_G.yaw - views.T_K_G.yaw) < 1e-6);
        CHECK(result.inliers == 80);
        CHECK(result.measurements == (with_depth ? 240 : 160));
    }
}

TEST_CASE("present depths make the pose surer") {
    const TwoViews views;
    SightingFit::State with;
    SightingFit::State without;
    CHECK(views.fit(with, true).covariance.trace() < 0.9 * views.fit(without, false).covariance.trace());
}

TEST_CASE("a tilt between two views is separated from a shift") {
    TwoViews views;
    views.tilt(0.0008, -0.001);  // 3 mm at a distance of 3 m
    SightingFit::State state;
    const SightingFit::Result result = views.fit(state);
    CHECK(views.error_m(state) < 1e-3);
    CHECK((state.tilt - Eigen::Vector2d(0.0008, -0.001)).norm() < 3e-4);
    CHECK(result.covariance.diagonal().tail<3>().maxCoeff() < 9e-6);
}

TEST_CASE("depths of a wrong calibration do not displace the pose beyond its covariance") {
    for (const double rho : {0.006, -0.006}) {  // 2 % at 3 m
        TwoViews views;
        SightingFit::State state;
        const double before = views.fit(state).covariance.diagonal().tail<3>().sum();
        TwoViews::offset(views.known, rho);
        const SightingFit::Result result = views.fit(state);
        const Eigen::Vector4d error = views.T_K_G.box_minus_to(state.T_K_G);
        CHECK(error.dot(result.covariance.inverse() * error) < 8.0);  // of four degrees of freedom
        CHECK(views.error_m(state) < 0.006);                          // a scale of 2 % on 0.51 m is 10 mm
        CHECK(result.covariance.diagonal().tail<3>().sum() > before);
    }
}

TEST_CASE("wrong sightings are outliers") {
    TwoViews views;
    for (std::size_t i = 0; i < views.seen.points.size(); i += 4) {
        views.seen.points[i].p_G.z() += 0.3F;
    }
    SightingFit::State state;
    const SightingFit::Result result = views.fit(state);
    CHECK(result.inliers == 60);
    CHECK(views.error_m(state) < 0.003);
}

}  // namespace
}  // namespace facet::sighting_fit_test
