// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/mavlink/frd.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace facet::frd_test {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180.0;

/// One motion in our frames and in MAVLink's.
struct Fixture {
    const char* what;
    // x forward, y left, z up
    Vector3d p_W;
    Vector3d turn_W_B;  ///< rotation vector (degrees)
    Vector3d v_W;
    Vector3d w_B;
    // x forward, y right, z down
    Vector3d p_F;
    Vector3d rpy_deg;
    Vector3d v_b;
    Vector3d v_F;
    Vector3d w_b;
};

const Vector3d kZero = Vector3d::Zero();

const Fixture kFixtures[] = {
    {"at the origin, level", kZero, kZero, kZero, kZero, kZero, kZero, kZero, kZero, kZero},
    {"1 m ahead, 2 m left, 3 m up", {1, 2, 3}, kZero, kZero, kZero, {1, -2, -3}, kZero, kZero, kZero, kZero},
    {"nose 30 degrees up", kZero, {0, -30, 0}, kZero, kZero, kZero, {0, 30, 0}, kZero, kZero, kZero},
    {"right wing 20 degrees down", kZero, {20, 0, 0}, kZero, kZero, kZero, {20, 0, 0}, kZero, kZero, kZero},
    {"turned 90 degrees to the right", kZero, {0, 0, -90}, kZero, kZero, kZero, {0, 0, 90}, kZero, kZero, kZero},
    {"turned left, flying ahead",
     kZero,
     {0, 0, 90},
     {0, 4, 0},
     kZero,
     kZero,
     {0, 0, -90},
     {4, 0, 0},
     {0, -4, 0},
     kZero},
    {"level, climbing and drifting left",
     kZero,
     kZero,
     {0, 1, 2},
     kZero,
     kZero,
     kZero,
     {0, -1, -2},
     {0, -1, -2},
     kZero},
    {"on its right side, falling",
     kZero,
     {90, 0, 0},
     {0, 0, -5},
     kZero,
     kZero,
     {90, 0, 0},
     {0, 5, 0},
     {0, 0, 5},
     kZero},
    {"rolling right, nose rising, turning right",
     kZero,
     kZero,
     kZero,
     {0.1, -0.2, -0.3},
     kZero,
     kZero,
     kZero,
     kZero,
     {0.1, 0.2, 0.3}},
};

Odometry odometry_of(const Fixture& f) {
    Odometry o;
    o.p_W_B = f.p_W;
    const double angle = f.turn_W_B.norm() * kDegree;
    if (angle > 0.0) {
        o.q_W_B = Quaterniond(AngleAxisd(angle, f.turn_W_B.normalized()));
    }
    o.v_W_B = f.v_W;
    o.w_B = f.w_B;
    o.quality = 50;
    return o;
}

FrdOdometry converted(const Odometry& o, const LocalFrame& local = {}) {
    FrdOdometry frd;
    REQUIRE(to_frd(o, local, frd) == Status::kOk);
    return frd;
}

Eigen::Matrix3d rotation(const FrdOdometry& o) {
    const auto& q = o.q_F_b_wxyz;
    return Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
}

TEST_CASE("every quantity in the frames of MAVLink") {
    for (const Fixture& f : kFixtures) {
        INFO(f.what);
        const FrdOdometry o = converted(odometry_of(f));
        CHECK((o.p_F - f.p_F).norm() < 1e-12);
        CHECK((o.rpy_rad - f.rpy_deg * kDegree).norm() < 1e-12);
        const Eigen::Matrix3d R_F_b = (AngleAxisd(f.rpy_deg.z() * kDegree, Vector3d::UnitZ()) *
                                       AngleAxisd(f.rpy_deg.y() * kDegree, Vector3d::UnitY()) *
                                       AngleAxisd(f.rpy_deg.x() * kDegree, Vector3d::UnitX()))
                                          .toRotationMatrix();
        CHECK((rotation(o) - R_F_b).norm() < 1e-12);
        CHECK((o.v_b - f.v_b).norm() < 1e-12);
        CHECK((o.v_F - f.v_F).norm() < 1e-12);
        CHECK((o.w_b - f.w_b).norm() < 1e-12);
        CHECK((rotation(o) * o.v_b - o.v_F).norm() < 1e-12);
    }
}

Matrix6d random_covariance(std::mt19937& random) {
    Matrix6d a;
    for (double& x : a.reshaped()) {
        x = std::normal_distribution<double>(0.0, 0.1)(random);
    }
    return a * a.transpose() + 1e-3 * Matrix6d::Identity();
}

TEST_CASE("covariances are those of the converted quantities, by their numeric derivatives") {
    std::mt19937 random(3);
    for (int run = 0; run < 50; ++run) {
        const auto draw = [&](double sigma) { return std::normal_distribution<double>(0.0, sigma)(random); };
        Odometry o;
        o.p_W_B = {draw(5), draw(5), draw(5)};
        o.q_W_B = AngleAxisd(draw(2), Vector3d::UnitZ()) * AngleAxisd(draw(0.4), Vector3d::UnitY()) *
                  AngleAxisd(draw(1), Vector3d::UnitX());
        o.v_W_B = {draw(1), draw(1), draw(1)};
        o.pose_covariance = random_covariance(random);
        o.v_covariance = random_covariance(random).topLeftCorner<3, 3>();
        o.w_covariance = random_covariance(random).topLeftCorner<3, 3>();
        const LocalFrame local{draw(1), {1, 2, 3}};
        const FrdOdometry frd = converted(o, local);
        Matrix6d d_pose;
        Eigen::Matrix<double, 6, 3> d_velocity;
        constexpr double kStep = 1e-6;
        const auto both = [&](double step, int i, auto change) {
            Odometry moved = o;
            change(moved, i, step);
            return converted(moved, local);
        };
        for (int i = 0; i < 6; ++i) {
            const auto move = [](Odometry& m, int axis, double step) {
                if (axis < 3) {
                    m.p_W_B[axis] += step;
                } else {
                    m.q_W_B = m.q_W_B * Quaterniond(AngleAxisd(step, Vector3d::Unit(axis - 3)));
                }
            };
            const FrdOdometry more = both(kStep, i, move);
            const FrdOdometry less = both(-kStep, i, move);
            d_pose.col(i) << (more.p_F - less.p_F) / (2 * kStep), (more.rpy_rad - less.rpy_rad) / (2 * kStep);
        }
        for (int i = 0; i < 3; ++i) {
            const auto move = [](Odometry& m, int axis, double step) { m.v_W_B[axis] += step; };
            const FrdOdometry more = both(kStep, i, move);
            const FrdOdometry less = both(-kStep, i, move);
            d_velocity.col(i) << (more.v_b - less.v_b) / (2 * kStep), (more.v_F - less.v_F) / (2 * kStep);
        }
        const Matrix6d velocity = d_velocity * o.v_covariance * d_velocity.transpose();
        INFO(frd.rpy_rad.transpose());
        REQUIRE(std::cos(frd.rpy_rad.y()) > FrdOdometry::kMinCosPitch);
        CHECK((frd.pose_covariance - d_pose * o.pose_covariance * d_pose.transpose()).norm() < 1e-5);
        CHECK((frd.twist_covariance.topLeftCorner<3, 3>() - velocity.topLeftCorner<3, 3>()).norm() < 1e-6);
        CHECK((frd.v_F_covariance - velocity.bottomRightCorner<3, 3>()).norm() < 1e-6);
        CHECK(frd.twist_covariance(4, 4) == Approx(o.w_covariance(1, 1)));
        CHECK(frd.twist_covariance(3, 5) == Approx(-o.w_covariance(0, 2)));
    }
}

TEST_CASE("with the nose straight up the covariance stays finite") {
    Odometry o;
    o.q_W_B = AngleAxisd(-90 * kDegree, Vector3d::UnitY());
    const FrdOdometry frd = converted(o);
    CHECK(frd.pose_covariance.allFinite());
    CHECK(frd.pose_covariance(5, 5) <= 1.0 / (FrdOdometry::kMinCosPitch * FrdOdometry::kMinCosPitch) + 1e-9);
    CHECK(frd.rpy_rad.y() == Approx(90 * kDegree));
}

TEST_CASE("home moves the origin, a heading turns the frame about the vehicle; speeds in the body do not change") {
    Odometry o;
    o.p_W_B = {3, 4, 5};
    o.q_W_B = Quaterniond(AngleAxisd(0.4, Vector3d::UnitZ()) * AngleAxisd(0.2, Vector3d::UnitX()));
    o.v_W_B = {std::cos(0.4), std::sin(0.4), 0};  // ahead
    const FrdOdometry before = converted(o);
    LocalFrame local = with_home_at({}, o);
    FrdOdometry frd = converted(o, local);
    CHECK(frd.p_F.norm() < 1e-12);
    CHECK(frd.rpy_rad.z() == Approx(-0.4));
    local = with_heading(local, o, 90 * kDegree);  // east
    frd = converted(o, local);
    CHECK(frd.p_F.norm() < 1e-12);
    CHECK(frd.rpy_rad.z() == Approx(90 * kDegree));
    CHECK(frd.rpy_rad.x() == Approx(before.rpy_rad.x()));
    CHECK((frd.v_F - Vector3d(0, 1, 0)).norm() < 1e-12);
    CHECK((frd.v_b - before.v_b).norm() < 1e-12);
    o.p_W_B += 2.0 * o.v_W_B;
    CHECK((converted(o, local).p_F - Vector3d(0, 2, 0)).norm() < 1e-12);
    const LocalFrame again = with_heading(local, o, 0.0);
    CHECK((converted(o, again).p_F - Vector3d(0, 2, 0)).norm() < 1e-12);
    CHECK(converted(o, again).rpy_rad.z() == Approx(0.0).margin(1e-12));
}

TEST_CASE("numbers that a flight controller must not get are refused") {
    const auto refused = [](auto change) {
        Odometry o = odometry_of(kFixtures[1]);
        change(o);
        FrdOdometry frd;
        frd.quality = 7;
        return to_frd(o, {}, frd) == Status::kInvalidArgument && frd.quality == 7;
    };
    const double nan = std::numeric_limits<double>::quiet_NaN();
    CHECK(refused([&](Odometry& o) { o.p_W_B.x() = nan; }));
    CHECK(refused([&](Odometry& o) { o.v_W_B.z() = HUGE_VAL; }));
    CHECK(refused([&](Odometry& o) { o.q_W_B.coeffs() *= 2.0; }));
    CHECK(refused([&](Odometry& o) { o.pose_covariance(2, 2) = 0.0; }));
    CHECK(refused([&](Odometry& o) { o.v_covariance(1, 1) = -1.0; }));
    CHECK(refused([&](Odometry& o) { o.quality = 101; }));
}

}  // namespace
}  // namespace facet::frd_test
