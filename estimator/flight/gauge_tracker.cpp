// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/flight/gauge_tracker.h"

#include <cmath>

namespace facet {
namespace {

// Of what images correct in the place after an outage, as much is wrong still: the velocity at its end tells what grew
// like its integral. Flights of real drones and simulated ones with vibration: 0.1 to 0.45, 6 to 8 s.
constexpr double kLeapShare = 0.3;

}  // namespace

void GaugeTracker::widen(const NavState& state, const Eigen::Vector3d& w_B, double dt_s) {
    slip_.is_refutable = false;
    gauge_ = gauge_.about(state.p_W_B);
    const auto add = [&c = gauge_.covariance](int i, double by) { c(i, i) = std::pow(std::sqrt(c(i, i)) + by, 2); };
    add(0, std::abs((state.q_W_B * w_B).z()) * dt_s);
    for (int i = 0; i < 3; ++i) {
        add(1 + i, state.v_W_B.norm() * dt_s);
    }
}

bool GaugeTracker::step(const SlipEvidence& e, const NavState& state, const Eigen::Vector3d& w_B) {
    if (e.is_high) {
        Slip seen = slip_.is_suspected ? slip_ : Slip{true, true, e.stamp, gauge_};
        seen.is_refutable = seen.is_refutable && is_compared_ && !e.is_keyframe;
        widen(state, w_B, e.dt_s);
        slip_ = seen;
        return true;
    }
    const bool is_refuted = slip_.is_refutable && is_compared_ && compared_with_ < slip_.begin;
    if (is_refuted) {
        gauge_ = slip_.gauge;
    }
    slip_ = {};
    return is_refuted;
}

void GaugeTracker::add_leap(const Eigen::Vector3d& p_W) {
    slip_ = {};  // the gauge of before is not to come back
    gauge_ = gauge_.about(p_W);
    gauge_.covariance.bottomRightCorner<3, 3>() += kLeapShare * kLeapShare * leap_W_ * leap_W_.transpose();
}

}  // namespace facet
