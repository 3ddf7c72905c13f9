// SPDX-License-Identifier: BSD-2-Clause
// The frame that consumers are told of, where it is not the IMU's.
#include "app/pipeline/to_odometry.h"

#include <catch2/catch.hpp>
#include <random>

#include "estimator/geometry/so3.h"

namespace facet::to_odometry_test {
namespace {

using Vector12d = Eigen::Matrix<double, 12, 1>;

/// A vehicle that turns while it flies, and a frame on it that is elsewhere and turned.
struct Flight {
    Flight() {
        estimate.stamp = {5'000'000'000};
        estimate.state.q_W_B = so3_exp({0.3, -0.2, 1.1});
        estimate.state.p_W_B = {1.0, -2.0, 0.5};
        estimate.state.v_W_B = {0.8, 0.3, -0.4};
        estimate.state.bias.gyro = {0.01, -0.02, 0.03};
        estimate.health.state = TrackingState::kTracking;
        estimate.health.quality = 90;
        std::mt19937 random(3);  // NOLINT(cert-msc51-cpp): fixed on purpose
        Eigen::Matrix<double, 9, 9> root;
        for (int i = 0; i < root.size(); ++i) {
            root.data()[i] = 1e-2 * (static_cast<double>(random()) / static_cast<double>(std::mt19937::max()) - 0.5);
        }
        estimate.covariance = root * root.transpose();
        noise.gyro_noise_rad_per_s_per_sqrt_hz = 1e-3;
        noise.rate_hz = 200.0;
    }
    Odometry reported() const { return to_odometry(estimate, w_measured, noise, T_body_imu); }

    Estimate estimate;
    ImuNoise noise;
    Eigen::Vector3d w_measured{0.7, -1.2, 2.0};
    Se3 T_body_imu{so3_exp({0.05, -0.1, 0.4}), {0.12, -0.03, 0.08}};
};

TEST_CASE("the reported frame is where the mount says, level as it says, and moves with the body") {
    Flight flight;
    const Odometry o = flight.reported();
    const Se3 T_W_B{flight.estimate.state.q_W_B, flight.estimate.state.p_W_B};
    const Se3 T_W_V = T_W_B * flight.T_body_imu.inverse();
    CHECK((o.p_W_B - T_W_V.p).norm() < 1e-12);
    CHECK(o.q_W_B.angularDistance(T_W_V.q) < 1e-12);
    // The same motion a moment later, in differences.
    constexpr double kStep_s = 1e-6;
    const Eigen::Vector3d w = flight.w_measured - flight.estimate.state.bias.gyro;
    const auto frame_at = [&](double t_s) {
        const Se3 T{(T_W_B.q * so3_exp(w * t_s)).normalized(), T_W_B.p + flight.estimate.state.v_W_B * t_s};
        return T * flight.T_body_imu.inverse();
    };
    const Eigen::Vector3d velocity = (frame_at(kStep_s).p - frame_at(-kStep_s).p) / (2.0 * kStep_s);
    CHECK((o.v_W_B - velocity).norm() < 1e-8);
    const Eigen::Vector3d rate = so3_log(frame_at(-kStep_s).q.conjugate() * frame_at(kStep_s).q) / (2.0 * kStep_s);
    CHECK((o.w_B - rate).norm() < 1e-8);
    CHECK(o.stamp == flight.estimate.stamp);
    CHECK(o.quality == 90);
}

TEST_CASE("its covariance is that of the estimate and the gyroscope, carried over") {
    Flight flight;
    const Odometry o = flight.reported();
    // Numeric derivative of [p theta v w] of the reported frame with respect to [theta p v w] of the estimate.
    const auto disturbed = [&](const Vector12d& d) {
        Flight other = flight;
        other.estimate.state.q_W_B = (flight.estimate.state.q_W_B * so3_exp(d.head<3>())).normalized();
        other.estimate.state.p_W_B += d.segment<3>(3);
        other.estimate.state.v_W_B += d.segment<3>(6);
        other.w_measured += d.tail<3>();
        const Odometry x = other.reported();
        Vector12d error;
        error << x.p_W_B - o.p_W_B, so3_log(o.q_W_B.conjugate() * x.q_W_B), x.v_W_B - o.v_W_B, x.w_B - o.w_B;
        return error;
    };
    Eigen::Matrix<double, 12, 12> J;
    constexpr double kStep = 1e-6;
    for (int i = 0; i < 12; ++i) {
        J.col(i) = (disturbed(kStep * Vector12d::Unit(i)) - disturbed(-kStep * Vector12d::Unit(i))) / (2.0 * kStep);
    }
    Eigen::Matrix<double, 12, 12> sigma = Eigen::Matrix<double, 12, 12>::Zero();
    sigma.topLeftCorner<9, 9>() = flight.estimate.covariance;
    sigma.bottomRightCorner<3, 3>() = 1e-6 * 200.0 * Eigen::Matrix3d::Identity();
    const Eigen::Matrix<double, 12, 12> expected = J * sigma * J.transpose();
    CHECK((o.pose_covariance - expected.topLeftCorner<6, 6>()).norm() < 1e-7 * expected.norm());
    CHECK((o.v_covariance - expected.block<3, 3>(6, 6)).norm() < 1e-7 * expected.norm());
    CHECK((o.w_covariance - expected.bottomRightCorner<3, 3>()).norm() < 1e-7 * expected.norm());
    // The lever arm must be seen in it.
    flight.T_body_imu = {};
    CHECK((flight.reported().pose_covariance - o.pose_covariance).norm() > 0.01 * o.pose_covariance.norm());
}

TEST_CASE("without a mount of its own no bit changes") {
    Flight flight;
    flight.T_body_imu = {};
    const Odometry o = flight.reported();
    CHECK(o.p_W_B == flight.estimate.state.p_W_B);
    CHECK(o.v_W_B == flight.estimate.state.v_W_B);
    CHECK(o.q_W_B.coeffs() == flight.estimate.state.q_W_B.coeffs());
    CHECK(o.w_B == flight.w_measured - flight.estimate.state.bias.gyro);
}

}  // namespace
}  // namespace facet::to_odometry_test
