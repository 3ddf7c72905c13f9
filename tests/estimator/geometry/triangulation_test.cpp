// SPDX-License-Identifier: BSD-2-Clause
// Triangulation: exact, far, noisy, with an outlier, and degenerate landmarks.
#include "estimator/geometry/triangulation.h"

#include <catch2/catch.hpp>
#include <random>
#include <vector>

namespace facet::triangulation_test {
namespace {

struct Scene {
    std::vector<CameraPose> cameras;
    std::vector<RelativeView> views;  ///< of cameras[0]
    std::vector<Sighting> sightings;
};

/// Cameras on a line, 0.1 m apart, slightly turned, all looking along z.
Scene see(const Eigen::Vector3d& p_W, int count, double sigma_px, unsigned seed = 1) {
    std::mt19937 generator(seed);
    std::normal_distribution<double> normal;
    Scene scene;
    for (int i = 0; i < count; ++i) {
        const Se3 T_W_C{so3_exp({0.01 * i, -0.02 * i, 0.03 * i}), {0.1 * i, 0.02 * i, -0.01 * i}};
        scene.cameras.push_back(CameraPose::from(T_W_C));
    }
    for (const CameraPose& camera : scene.cameras) {
        scene.views.push_back(RelativeView::of(camera, scene.cameras[0]));
    }
    for (std::size_t i = 0; i < scene.cameras.size(); ++i) {
        const CameraPose& camera = scene.cameras[i];
        const Eigen::Vector3d p_C = camera.R_C_W * (p_W - camera.p_W_C);
        const double noise_x = sigma_px / 450.0 * normal(generator);
        const double noise_y = sigma_px / 450.0 * normal(generator);
        scene.sightings.push_back({&scene.views[i], p_C.head<2>() / p_C.z() + Eigen::Vector2d(noise_x, noise_y),
                                   450.0 * Eigen::Matrix2d::Identity()});
    }
    return scene;
}

}  // namespace

TEST_CASE("triangulation finds exact points, near and far", "[triangulation]") {
    TriangulationOptions options;
    options.rho_prior_sigma = 1e6;
    options.max_iterations = 10;
    for (const double depth : {0.5, 2.0, 20.0, 300.0}) {
        const Eigen::Vector3d p_W(0.1 * depth, -0.2 * depth, depth);
        const Scene scene = see(p_W, 5, 0.0);
        InverseDepthPoint point;
        REQUIRE(ok(triangulate_linear(scene.sightings, point)));
        CHECK(point.rho == Approx(1.0 / depth).epsilon(1e-6));
        point.rho *= 1.3;
        REQUIRE(ok(triangulate(scene.sightings, options, point)));
        CHECK((ScaledWorldPoint(scene.cameras[0], point).p_W() - p_W).norm() < 1e-6 * depth);
    }
}

TEST_CASE("triangulation puts a point without parallax at infinity", "[triangulation]") {
    const Scene scene = see({1e7, 2e7, 1e8}, 4, 0.0);
    InverseDepthPoint point;
    REQUIRE(ok(triangulate_linear(scene.sightings, point)));
    REQUIRE(ok(triangulate(scene.sightings, {}, point)));
    CHECK(point.rho >= 0.0);
    CHECK(point.rho < 1e-4);
}

TEST_CASE("triangulation is robust against one wrong sighting", "[triangulation]") {
    const Eigen::Vector3d p_W(0.2, 0.1, 3.0);
    Scene scene = see(p_W, 9, 0.3);
    scene.sightings[4].xy += Eigen::Vector2d(0.05, -0.04);  // 29 px
    InverseDepthPoint point;
    TriangulationOptions options;
    options.max_iterations = 20;
    REQUIRE(ok(triangulate_linear(scene.sightings, point)));
    REQUIRE(ok(triangulate(scene.sightings, options, point)));
    CHECK((ScaledWorldPoint(scene.cameras[0], point).p_W() - p_W).norm() < 0.04);
}

TEST_CASE("triangulation refuses what it cannot determine", "[triangulation]") {
    InverseDepthPoint point;
    point.rho = 0.123;
    const Scene one = see({0.0, 0.0, 2.0}, 1, 0.0);
    CHECK(triangulate_linear(one.sightings, point) == Status::kDegenerate);

    Scene same = see({0.0, 0.0, 2.0}, 2, 0.0);
    same.sightings[1].view = same.sightings[0].view;  // no baseline
    CHECK(triangulate_linear(same.sightings, point) == Status::kDegenerate);

    Scene behind = see({0.0, 0.0, 2.0}, 2, 0.0);
    behind.cameras[1].p_W_C.z() = 5.0;  // has flown past the point
    behind.views[1] = RelativeView::of(behind.cameras[1], behind.cameras[0]);
    InverseDepthPoint start{behind.sightings[0].xy, 0.5};
    CHECK(triangulate(behind.sightings, {}, start) == Status::kDegenerate);
    CHECK(start.rho == 0.5);

    const Scene near = see({0.0, 0.0, 0.05}, 3, 0.0);  // nearer than 1 / max_rho
    InverseDepthPoint too_near{near.sightings[0].xy, 20.0};
    CHECK(triangulate(near.sightings, {}, too_near) == Status::kDegenerate);
    CHECK(too_near.rho == 20.0);
    CHECK(point.rho == 0.123);
}

}  // namespace facet::triangulation_test
