// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/flight/inertial_fault.h"

#include <algorithm>
#include <cmath>

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
// Over shorter intervals poses tell next to nothing of a force.
constexpr double kLeastInterval_s = 0.08;
constexpr int kFew = 4;  // one in so many
constexpr int kHalf = 2;
constexpr int kNearlyAll = 5;  // all but one in so many

/// What the poses of three keyframes in a row can tell of readings (1 sigma).
struct Resolution {
    Resolution(const Preintegration& ij, const Preintegration& jk)
        : is_known(ij.dt_s() >= kLeastInterval_s && jk.dt_s() >= kLeastInterval_s),
          gyro(kTurn_rad / jk.dt_s()),
          accel(2.0 * kSecondDifference * kPlace_m / (jk.dt_s() * (jk.dt_s() + ij.dt_s()))) {}

    bool is_known;
    double gyro;   ///< rad/s
    double accel;  ///< m/s^2
};

StepNoise density(double gyro, double accel) {
    return {Eigen::Vector3d::Constant(gyro * gyro * kAlike_s), Eigen::Vector3d::Constant(accel * accel * kAlike_s)};
}

}  // namespace

StepNoise InertialFault::unlimited(const ImuLimits& limits) {
    return density(limits.gyro_range_rad_per_s, limits.accel_range_m_per_s2);
}

bool InertialFault::is_called_for(const FrameEstimate& usual, const Limits& limits, bool is_stuck) {
    // Readings that lead astray slowly leave the tracks behind one by one: then those that are left fit.
    const bool is_left_behind = (is_stuck ? kHalf : kFew) * usual.agreeing < usual.landmarks;
    return is_left_behind || usual.chi2 > (is_stuck ? limits.good_chi2 : limits.wrong_chi2) ||
           usual.inertial_chi2 > (is_stuck ? kStuckChi2 : kBentChi2);
}

bool InertialFault::is_justified(const FrameEstimate& usual, const FrameEstimate& free, const Limits& limits,
                                 bool is_stuck) {
    const bool is_rigid = free.chi2 < limits.good_chi2 && kHalf * free.agreeing > free.landmarks;
    const bool is_one_piece = kNearlyAll * (free.landmarks - free.agreeing) < free.landmarks;
    return is_rigid &&
           (kFew * usual.agreeing < free.agreeing || ((is_stuck || usual.inertial_chi2 > kBentChi2) && is_one_piece));
}

StepNoise InertialFault::noise() const { return density(gyro_left_, accel_left_); }

StepNoise InertialFault::noise_between(const Preintegration& as_read, const Preintegration& as_replaced) {
    const Eigen::Vector3d turn = so3_log(as_replaced.delta_q().conjugate() * as_read.delta_q());
    const Eigen::Vector3d push = as_read.delta_v() - as_replaced.delta_v();
    return density(turn.norm() / as_read.dt_s(), push.norm() / as_read.dt_s());
}

void InertialFault::end() {
    axes_ = 0;
    has_hung_ = false;
    agreements_ = 0;
}

void InertialFault::see(Timestamp stamp, const NavState& state) {
    const double dt_s = (stamp - seen_).seconds();
    if (has_seen_ && dt_s > 0.0) {
        w_B_ = so3_log(q_W_B_.conjugate() * state.q_W_B) / dt_s;
    }
    has_seen_ = true;
    seen_ = stamp;
    q_W_B_ = state.q_W_B;
}

SteadyMotion InertialFault::steady(const NavState& from, double gravity_m_per_s2) const {
    return {w_B_, from.q_W_B.conjugate() * -gravity_W(gravity_m_per_s2), from.bias};
}

ReplacedReadings InertialFault::readings(const NavState& from, double gravity_m_per_s2) const {
    return is_active() ? ReplacedReadings{axes_, steady(from, gravity_m_per_s2), noise()} : ReplacedReadings{};
}

void InertialFault::begin(const NavState& i, const NavState& j, const Preintegration& ij, ImuAxisMask stuck) {
    const double h = ij.dt_s();
    const ImuBias found = inertial_error(i, j, ij);
    const bool is_gyro = found.gyro.norm() > kConfidence * kTurn_rad / h;
    const bool is_accel = found.accel.norm() > kConfidence * 2.0 * kPlace_m / (h * h);
    const ImuAxisMask clear = is_gyro == is_accel ? 0 : (is_gyro ? kGyroAxes : kAccelAxes);
    // Of two sensors the one that hangs is at fault, unless it is clearly the other: in simulations both may repeat.
    const auto suspects = static_cast<ImuAxisMask>(stuck & ~axes_);
    has_hung_ = suspects != 0 && (clear == 0 || (clear & suspects) != 0);
    // Readings that are replaced already say nothing of which of the sensors it is.
    const ImuAxisMask found_axes = is_active() || clear == 0 ? kGyroAxes | kAccelAxes : clear;
    axes_ = has_hung_ ? static_cast<ImuAxisMask>(axes_ | (clear != 0 ? clear : suspects)) : found_axes;
    agreements_ = 0;
    w_B_ = so3_log(i.q_W_B.conjugate() * j.q_W_B) / h;
}

void InertialFault::measure(const NavState& i, const NavState& j, const Preintegration& ij) {
    const double h = ij.dt_s();
    const ImuBias left = inertial_error(i, j, ij);
    gyro_left_ = std::max(left.gyro.norm(), kTurn_rad / h);
    accel_left_ = std::max(left.accel.norm(), 2.0 * kPlace_m / (h * h));
}

void InertialFault::follow(std::span<const Keyframe, 3> last, ImuBuffer& imu, const ImuNoise& noise,
                           const Preintegration& empty) {
    const Keyframe& i = last[0];
    const Keyframe& j = last[1];
    const Keyframe& k = last[2];
    measure(i.state, j.state, k.state, j.imu_from_previous.preintegration(), k.imu_from_previous.preintegration());
    Preintegration ij = empty;
    Preintegration jk = empty;
    ij.reset(i.state.bias);
    jk.reset(j.state.bias);
    ImuSpan span_ij;
    ImuSpan span_jk;
    imu.exchange_as_read();
    const bool is_read = ok(imu.integrate_between(i.stamp, j.stamp, noise, ij, &span_ij)) &&
                         ok(imu.integrate_between(j.stamp, k.stamp, noise, jk, &span_jk));
    imu.exchange_as_read();
    if (has_hung_ && ((span_ij.stuck | span_jk.stuck) & axes_) != 0) {
        agreements_ = 0;
    } else if (is_read) {
        judge(i.state, j.state, k.state, ij, jk);
    }
}

void InertialFault::measure(const NavState& i, const NavState& j, const NavState& k, const Preintegration& ij,
                            const Preintegration& jk) {
    const Resolution least(ij, jk);
    if (least.is_known) {
        const ImuBias left = inertial_error(i, j, k, ij, jk);
        gyro_left_ = std::max(left.gyro.norm(), least.gyro);
        accel_left_ = std::max(left.accel.norm(), least.accel);
    }
}

void InertialFault::judge(const NavState& i, const NavState& j, const NavState& k, const Preintegration& ij,
                          const Preintegration& jk) {
    const Resolution least(ij, jk);
    if (!least.is_known) {
        return;
    }
    const ImuBias off = inertial_error(i, j, k, ij, jk);
    const bool turns_alike = off.gyro.norm() < kConfidence * least.gyro;
    const bool moves_alike = off.accel.norm() < kConfidence * least.accel;
    agreements_ = turns_alike && moves_alike ? agreements_ + 1 : 0;
    if (agreements_ == (has_hung_ ? 1 : kAgreements)) {
        end();
    }
}

}  // namespace facet
