// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/flight/camera_roles.h"

#include <array>
#include <catch2/catch.hpp>

#include "estimator/geometry/so3.h"

namespace facet::camera_roles_test {
namespace {

Timestamp at_ms(std::int64_t ms) { return Timestamp{ms * 1'000'000}; }

StereoRig example_rig() {
    StereoRig rig;
    rig.T_B_C0 = {so3_exp({0.1, 0.2, -0.1}), {0.02, 0.05, 0.01}};
    rig.T_B_C1 = {so3_exp({0.12, 0.19, -0.1}), {0.02, -0.06, 0.01}};
    return rig;
}

struct Images {
    std::array<std::uint8_t, 4> pixels{};
    ImageView image{pixels.data(), 2, 2, 2};

    StereoFrame pair(std::int64_t ms) const { return {at_ms(ms), image, image}; }
    StereoFrame left(std::int64_t ms) const { return {at_ms(ms), image, {}}; }
    StereoFrame right(std::int64_t ms) const { return {at_ms(ms), {}, image}; }
};

}  // namespace

TEST_CASE("the right camera takes over once the left one has been silent for 0.3 s", "[camera_roles]") {
    const Images images;
    CameraRoles roles(example_rig());
    CHECK_FALSE(roles.must_exchange(images.pair(0)));
    roles.step(images.pair(0));
    CHECK_FALSE(roles.must_exchange(images.right(250)));
    CHECK(roles.step(images.right(250)).left.empty());
    REQUIRE(roles.must_exchange(images.right(350)));
    roles.exchange({});
    CHECK(roles.is_exchanged());
    CHECK((roles.rig().T_B_C0.p - example_rig().T_B_C1.p).norm() == 0.0);
    const StereoFrame seen = roles.step(images.right(350));
    CHECK_FALSE(seen.left.empty());
    CHECK(seen.right.empty());
    CHECK(roles.is_alone(roles.step(images.right(400))));
    CHECK_FALSE(roles.misses_camera(at_ms(900)));
    CHECK(roles.misses_camera(at_ms(1100)));
}

TEST_CASE("a right camera that begins alone takes over at once", "[camera_roles]") {
    const Images images;
    CHECK(CameraRoles(example_rig()).must_exchange(images.right(0)));
}

TEST_CASE("a single dropped image leaves no camera alone", "[camera_roles]") {
    const Images images;
    CameraRoles roles(example_rig());
    roles.step(images.pair(0));
    CHECK_FALSE(roles.is_alone(roles.step(images.left(50))));
    roles.forget_frames();
    CHECK_FALSE(roles.misses_camera(at_ms(5000)));
}

TEST_CASE("a rig of one camera has no roles to exchange, and misses nobody", "[camera_roles]") {
    const Images images;
    StereoRig rig = example_rig();
    rig.has_right = false;
    CameraRoles roles(rig);
    CHECK(roles.is_alone(roles.step(images.left(0))));
    CHECK_FALSE(roles.must_exchange(images.right(1000)));
    CHECK_FALSE(roles.misses_camera(at_ms(5000)));
}

TEST_CASE("corrections keep both cameras where they are, and the IMU's axes, when roles are exchanged",
          "[camera_roles]") {
    RigCalibration::Tangent d = RigCalibration::Tangent::Constant(1e-3);
    d(kTimeOffset) = 2e-3;
    const RigCalibration corrections = RigCalibration{}.box_plus(d);
    const StereoRig rig = example_rig();
    CameraRoles roles(rig);
    const RigCalibration other = roles.exchange(corrections);
    const Se3 right = corrections.T_B_Bc * corrections.T_Bc_C1(rig.T_B_C1);
    const Se3 right_as_left = other.T_B_Bc * roles.rig().T_B_C0;
    CHECK((right.p - right_as_left.p).norm() < 1e-12);
    CHECK(right.q.angularDistance(right_as_left.q) < 1e-9);
    CHECK(other.time_offset_s == corrections.time_offset_s);
    CHECK(corrections.imu.box_minus_to(other.imu).norm() == 0.0);
    CHECK(corrections.box_minus_to(roles.as_given(other)).norm() < 1e-9);
}

}  // namespace facet::camera_roles_test
