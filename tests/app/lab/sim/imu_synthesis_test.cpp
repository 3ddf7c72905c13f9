// SPDX-License-Identifier: BSD-2-Clause
// Inertial samples: integration gives the flight back; noise and bias have the stated strength.
#include "app/lab/sim/imu_synthesis.h"

#include <catch2/catch.hpp>

#include "app/lab/sim/default_rig.h"
#include "app/support/rng.h"
#include "estimator/geometry/so3.h"

namespace facet::sim::imu_synthesis_test {
namespace {

/// A lively flight: control points at random, accelerations of metres per second squared, rates around 1 rad/s.
Flight lively_flight() {
    RandomStream random(3, 1);
    std::vector<Flight::Spline::Vector> control;
    for (int i = 0; i < 40; ++i) {
        Flight::Spline::Vector c;
        c << random.uniform(-0.6, 0.6), random.uniform(-0.6, 0.6), random.uniform(0.7, 1.3), random.uniform(-0.3, 0.3),
            random.uniform(-0.3, 0.3), 0.25 * i;
        control.push_back(c);
    }
    return Flight(Flight::Spline(0.35, control));
}

struct Drift {
    double position_m = 0.0;  ///< worst over the time
    double angle_rad = 0.0;   ///< at the end
};

/// Trapezoidal dead reckoning from the true first state against the true states.
Drift dead_reckon(const std::vector<ImuRecord>& records) {
    Eigen::Quaterniond q = records[0].state.T_W_B.q;
    Eigen::Vector3d p = records[0].state.T_W_B.p;
    Eigen::Vector3d v = records[0].state.v_W;
    Drift drift;
    for (std::size_t k = 0; k + 1 < records.size(); ++k) {
        const double dt = records[k + 1].t_s - records[k].t_s;
        const Eigen::Vector3d w = 0.5 * (records[k].sample.w_B + records[k + 1].sample.w_B);
        const Eigen::Quaterniond q_next = q * so3_exp(w * dt);
        const Eigen::Vector3d a =
            0.5 * (q * records[k].sample.a_B + q_next * records[k + 1].sample.a_B) + gravity_W(9.81);
        p += v * dt + 0.5 * a * dt * dt;
        v += a * dt;
        q = q_next;
        drift.position_m = std::max(drift.position_m, (p - records[k + 1].state.T_W_B.p).norm());
    }
    drift.angle_rad = so3_log(q.conjugate() * records.back().state.T_W_B.q).norm();
    return drift;
}

TEST_CASE("Integrating exact samples reproduces the flight, with an error of second order in the step") {
    const Flight flight = lively_flight();
    const std::vector<ImuRecord> records = synthesise_imu(flight, 5.0, Timestamp{5}, {}, 1);
    REQUIRE(records.size() == 1001);
    CHECK(records[1].sample.stamp.ns == 5'000'005);
    double fastest = 0.0;
    for (const ImuRecord& r : records) {
        fastest = std::max(fastest, r.sample.w_B.norm());
    }
    CHECK(fastest > 0.7);
    CHECK(dead_reckon(records).position_m < 2e-3);
    CHECK(dead_reckon(records).angle_rad < 1e-4);
    const Drift coarse = dead_reckon(synthesise_imu(flight, 10.0, Timestamp{5}, {}, 1));
    const Drift fine = dead_reckon(synthesise_imu(flight, 10.0, Timestamp{5}, {.rate_hz = 800.0}, 1));
    CHECK(fine.position_m < coarse.position_m / 14.0);
    CHECK(fine.position_m < 3e-4);
}

TEST_CASE("A sensor at rest reads gravity upwards") {
    const Flight still(Flight::Spline(1.0, std::vector<Flight::Spline::Vector>(8, Flight::Spline::Vector::Zero())));
    const std::vector<ImuRecord> records = synthesise_imu(still, 1.0, Timestamp{0}, {}, 1);
    CHECK((records[50].sample.a_B - Eigen::Vector3d(9.81, 0.0, 0.0)).norm() < 1e-9);
    CHECK(records[50].sample.w_B.norm() < 1e-12);
}

TEST_CASE("Noise and bias walk have the densities asked for") {
    const Flight flight = lively_flight();
    const ImuNoise noise = euroc_imu_noise();
    const std::vector<ImuRecord> exact = synthesise_imu(flight, 12.0, Timestamp{0}, {}, 9);
    const std::vector<ImuRecord> noisy = synthesise_imu(flight, 12.0, Timestamp{0}, {.noise = &noise}, 9);
    double gyro2 = 0.0;
    double accel2 = 0.0;
    double gyro_walk2 = 0.0;
    double accel_walk2 = 0.0;
    for (std::size_t k = 1; k < exact.size(); ++k) {
        gyro2 += (noisy[k].sample.w_B - exact[k].sample.w_B - noisy[k].bias.gyro).squaredNorm();
        accel2 += (noisy[k].sample.a_B - exact[k].sample.a_B - noisy[k].bias.accel).squaredNorm();
        gyro_walk2 += (noisy[k].bias.gyro - noisy[k - 1].bias.gyro).squaredNorm();
        accel_walk2 += (noisy[k].bias.accel - noisy[k - 1].bias.accel).squaredNorm();
    }
    const double n = 3.0 * static_cast<double>(exact.size() - 1);
    CHECK(std::sqrt(gyro2 / n / 200.0) == Approx(1.6968e-4).epsilon(0.05));
    CHECK(std::sqrt(accel2 / n / 200.0) == Approx(2.0e-3).epsilon(0.05));
    CHECK(std::sqrt(gyro_walk2 / n * 200.0) == Approx(1.9393e-5).epsilon(0.05));
    CHECK(std::sqrt(accel_walk2 / n * 200.0) == Approx(3.0e-3).epsilon(0.05));
    CHECK(noisy[0].bias.gyro.norm() > 1e-3);
    CHECK(noisy[0].bias.accel.norm() > 1e-3);
    const std::vector<ImuRecord> other = synthesise_imu(flight, 12.0, Timestamp{0}, {.noise = &noise}, 10);
    CHECK((other[0].bias.gyro - noisy[0].bias.gyro).norm() > 1e-4);
}

}  // namespace
}  // namespace facet::sim::imu_synthesis_test
