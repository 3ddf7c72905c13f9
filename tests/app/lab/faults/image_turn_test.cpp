// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/faults/image_turn.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "app/lab/sim/default_rig.h"
#include "estimator/geometry/stereo_rig.h"

namespace facet::image_turn_test {
namespace {

/// Black, with a bright spot of 3 px that is centred here.
GreyImage spot(const CameraModel& camera, const Eigen::Vector2d& centre) {
    const CameraIntrinsics& k = camera.intrinsics();
    GreyImage image{.width = k.width, .height = k.height, .pixels = {}};
    for (int v = 0; v < k.height; ++v) {
        for (int u = 0; u < k.width; ++u) {
            const double r2 = (Eigen::Vector2d(u, v) - centre).squaredNorm();
            image.pixels.push_back(static_cast<std::uint8_t>(250.0 * std::exp(-r2 / 18.0) + 0.5));
        }
    }
    return image;
}

Eigen::Vector2d centre_of(const GreyImage& image) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    double weight = 0.0;
    for (int v = 0; v < image.height; ++v) {
        for (int u = 0; u < image.width; ++u) {
            const double grey = image.view().at(u, v);
            sum += grey * Eigen::Vector2d(u, v);
            weight += grey;
        }
    }
    return sum / weight;
}

CameraModel without_distortion(const CameraModel& camera) {
    CameraIntrinsics k = camera.intrinsics();
    k.distortion = Distortion::kNone;
    k.coeffs = {};
    return CameraModel(k);
}

TEST_CASE("what is seen in the middle moves by the focal length times the angle, against the turn") {
    const StereoRig rig = sim::euroc_rig();
    const CameraModel camera = without_distortion(rig.left);
    const CameraIntrinsics& k = camera.intrinsics();
    const Eigen::Vector2d middle(k.cx, k.cy);
    ImageTurn turn(camera, rig.T_B_C0.q);
    for (const double angle : {-2e-3, -0.4e-3, 0.4e-3, 2e-3}) {
        INFO(angle);
        GreyImage image = spot(camera, middle);
        turn.apply(rig.T_B_C0.q * Eigen::Vector3d(0.0, angle, 0.0), image);  // to the right, about the downward axis
        const Eigen::Vector2d moved = centre_of(image) - middle;
        CHECK(moved.x() == Approx(-k.fx * angle).margin(0.02));
        CHECK(moved.y() == Approx(0.0).margin(0.02));
    }
}

TEST_CASE("off the middle, each camera's image moves as its lens and mount have it") {
    const StereoRig rig = sim::euroc_rig();
    const Eigen::Vector3d theta_B(1.5e-3, -0.8e-3, 2.2e-3);
    for (const bool is_right : {false, true}) {
        const CameraModel& camera = is_right ? rig.right : rig.left;
        const Eigen::Matrix3d R_B_C = (is_right ? rig.T_B_C1 : rig.T_B_C0).q.toRotationMatrix();
        ImageTurn turn(camera, Eigen::Quaterniond(R_B_C));
        for (const Eigen::Vector2d& from : {Eigen::Vector2d(90.0, 80.0), Eigen::Vector2d(650.0, 400.0)}) {
            Eigen::Vector2d xy;
            REQUIRE(ok(camera.unproject(from, xy)));
            // A far point stands still in the world: the body turns about theta_B, so it turns the other way in B.
            const Eigen::Vector3d p_B = R_B_C * xy.homogeneous();
            const Eigen::Vector3d turned_B = Eigen::AngleAxisd(-theta_B.norm(), theta_B.normalized()) * p_B;
            Eigen::Vector2d to;
            REQUIRE(ok(camera.project(R_B_C.transpose() * turned_B, to)));
            GreyImage image = spot(camera, from);
            turn.apply(theta_B, image);
            CHECK((centre_of(image) - to).norm() < 0.02);
            CHECK((to - from).norm() > 0.3);
        }
    }
}

TEST_CASE("no turn changes nothing, and images of another size stay") {
    const StereoRig rig = sim::euroc_rig();
    ImageTurn turn(rig.left, rig.T_B_C0.q);
    const GreyImage image = spot(rig.left, {100.0, 100.0});
    GreyImage still = image;
    turn.apply(Eigen::Vector3d::Zero(), still);
    CHECK(still.pixels == image.pixels);
    GreyImage small{.width = 2, .height = 1, .pixels = {3, 200}};
    turn.apply({0.1, 0.1, 0.1}, small);
    CHECK(small.pixels == std::vector<std::uint8_t>{3, 200});
}

TEST_CASE("outside a fisheye's circle nothing moves") {
    const StereoRig rig = sim::fisheye_rig();
    ImageTurn turn(rig.left, rig.T_B_C0.q);
    const CameraIntrinsics& k = rig.left.intrinsics();
    GreyImage image{.width = k.width, .height = k.height, .pixels = {}};
    for (int i = 0; i < k.width * k.height; ++i) {
        image.pixels.push_back(static_cast<std::uint8_t>(7 * i));
    }
    const GreyImage before = image;
    turn.apply({0.0, 5e-3, 5e-3}, image);
    REQUIRE_FALSE(rig.left.in_lens({0.0, 0.0}, 0.0));
    CHECK(image.view().at(0, 0) == before.view().at(0, 0));
    CHECK(image.view().at(1, 0) == before.view().at(1, 0));
    CHECK(image.pixels != before.pixels);
}

}  // namespace
}  // namespace facet::image_turn_test
