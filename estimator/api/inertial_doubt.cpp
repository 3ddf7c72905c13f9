// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/api/inertial_doubt.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "estimator/geometry/so3.h"
#include "estimator/imu/inertial_error.h"

namespace facet {
namespace {

// What the true motion differs from the steady one by stays alike for about the time between keyframes: as white noise,
// a deviation s has the density s^2 T.
constexpr double kAlike_s = 0.25;
// What the poses of keyframes in a row may be off by, relative to each other.
constexpr double kPlace_m = 0.003;
constexpr double kTurn_rad = 0.002;
// Second differences of places over equal intervals have sqrt(1 + 4 + 1) times their deviation.
constexpr double kSecondDifference = 2.45;
constexpr double kConfidence = 3.0;
constexpr int kAgreements = 2;
constexpr int kTilts = 4;
// Over shorter intervals poses tell next to nothing of a force.
constexpr double kLeastInterval_s = 0.08;
constexpr int kFew = 4;
constexpr double kMostTilt_m_per_s2 = 5.0;  // half a radian's

StepNoise density(double gyro, double accel) {
    return {Eigen::Vector3d::Constant(gyro * gyro * kAlike_s), Eigen::Vector3d::Constant(accel * accel * kAlike_s)};
}

}  // namespace

StepNoise InertialDoubt::unlimited(const ImuLimits& limits) {
    return density(limits.gyro_range_rad_per_s, limits.accel_range_m_per_s2);
}

bool InertialDoubt::is_justified(const FrameEstimate& usual, const FrameEstimate& free, double good_chi2) {
    return free.chi2 < good_chi2 && 2 * free.agreeing > free.landmarks && kFew * usual.agreeing < free.agreeing;
}

StepNoise InertialDoubt::noise() const { return density(gyro_left_, accel_left_); }

void InertialDoubt::end() {
    axes_ = 0;
    agreements_ = tilts_ = 0;
    tilt_rad_ = 0.0;
}

void InertialDoubt::see(Timestamp stamp, const NavState& state) {
    const double dt_s = (stamp - seen_).seconds();
    if (has_seen_ && dt_s > 0.0) {
        w_B_ = so3_log(q_W_B_.conjugate() * state.q_W_B) / dt_s;
    }
    has_seen_ = true;
    seen_ = stamp;
    q_W_B_ = state.q_W_B;
}

SteadyMotion InertialDoubt::steady(const NavState& from, double gravity_m_per_s2) const {
    return {w_B_, from.q_W_B.conjugate() * -gravity_W(gravity_m_per_s2), from.bias};
}

DoubtedReadings InertialDoubt::readings(const NavState& from, double gravity_m_per_s2) const {
    return is_active() ? DoubtedReadings{axes_, steady(from, gravity_m_per_s2), noise()} : DoubtedReadings{};
}

void InertialDoubt::begin(const NavState& i, const NavState& j, const Preintegration& ij) {
    const double h = ij.dt_s();
    const ImuBias found = inertial_error(i, j, ij);
    const bool is_gyro = found.gyro.norm() > kConfidence * kTurn_rad / h;
    const bool is_accel = found.accel.norm() > kConfidence * 2.0 * kPlace_m / (h * h);
    // Readings that are replaced already say nothing of which of the sensors it is.
    const bool is_unclear = is_active() || is_gyro == is_accel;
    axes_ = is_unclear ? kGyroAxes | kAccelAxes : (is_gyro ? kGyroAxes : kAccelAxes);
    agreements_ = 0;
    w_B_ = so3_log(i.q_W_B.conjugate() * j.q_W_B) / h;
}

void InertialDoubt::measure(const NavState& i, const NavState& j, const Preintegration& ij) {
    const double h = ij.dt_s();
    const ImuBias left = inertial_error(i, j, ij);
    gyro_left_ = std::max(left.gyro.norm(), kTurn_rad / h);
    accel_left_ = std::max(left.accel.norm(), 2.0 * kPlace_m / (h * h));
}

void InertialDoubt::follow(const NavState& i, const NavState& j, const NavState& k, const Preintegration& ij,
                           const Preintegration& jk, const ImuBias& replaced_ij, const ImuBias& replaced_jk) {
    const double h_ij = ij.dt_s();
    const double h = jk.dt_s();
    if (h < kLeastInterval_s || h_ij < kLeastInterval_s) {
        return;
    }
    const ImuBias left = inertial_error(i, j, k, ij, jk);
    const double gyro_resolution = kTurn_rad / h;
    const double accel_resolution = 2.0 * kSecondDifference * kPlace_m / (h * (h + h_ij));
    gyro_left_ = std::max(left.gyro.norm(), gyro_resolution);
    accel_left_ = std::max(left.accel.norm(), accel_resolution);
    const Eigen::Vector3d gyro_read = left.gyro + replaced_jk.gyro;
    const Eigen::Vector3d accel_read = left.accel + 0.5 * (replaced_ij.accel + replaced_jk.accel);
    const bool turns_alike = gyro_read.norm() < kConfidence * gyro_resolution;
    const bool moves_alike = accel_read.norm() < kConfidence * accel_resolution;
    agreements_ = turns_alike && moves_alike ? agreements_ + 1 : 0;
    const bool is_tilt = is_same_tilt(j.q_W_B * accel_read, kConfidence * accel_resolution);
    tilts_ = turns_alike && !moves_alike && is_tilt ? tilts_ + 1 : 0;
    if (agreements_ == kAgreements || tilts_ == kTilts) {
        const double tilt = agreements_ == kAgreements ? 0.0 : force_W_.norm() / jk.gravity_m_per_s2();
        end();
        tilt_rad_ = tilt;
    }
}

bool InertialDoubt::is_same_tilt(const Eigen::Vector3d& force_W, double tolerance) {
    const bool is_level = std::abs(force_W.z()) < tolerance && force_W.norm() < kMostTilt_m_per_s2;
    const bool is_same = (force_W - force_W_).norm() < std::numbers::sqrt2 * tolerance;
    force_W_ = force_W;
    return is_level && is_same;
}

}  // namespace facet
