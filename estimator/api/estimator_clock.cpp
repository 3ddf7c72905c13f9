// SPDX-License-Identifier: BSD-2-Clause
// What the estimator does when time is on no clock: a clock has gone back, for a while or for good.
#include <algorithm>
#include <cmath>

#include "estimator/api/estimator_impl.h"

namespace facet {
namespace {

// A clock that is behind by no more than this catches up soon enough, and what is known until then is worth more.
constexpr Duration kBehind = Duration::from_seconds(1.0);
// What a vehicle may have done, beyond going on as before, in time that nothing was known of.
constexpr double kUnknown_m_per_s = 2.0;
constexpr double kUnknown_rad_per_s = 0.5;

}  // namespace

void Estimator::Impl::allow_for_lost_time(double lost_s) {
    if (lost_s > RefusedRun::kLeast_s) {
        widen_gauge(lost_s);
        lost_time_s += lost_s;
        reset_wanted = true;
    }
}

bool Estimator::Impl::is_on_new_clock() const {
    return refused_samples.is_clock() && has_offered && offered >= refused_samples.clock_begin() &&
           offered <= refused_samples.newest() && imu.newest() - refused_samples.newest() > kBehind;
}

void Estimator::Impl::widen_trusted(double lost_s) {
    const double turned_rad = (std::abs((trusted.state.q_W_B * doubt.rate_B()).z()) + kUnknown_rad_per_s) * lost_s;
    const double flown_m = (trusted.state.v_W_B.norm() + kUnknown_m_per_s) * lost_s;
    trusted.covariance.diagonal().segment<3>(kTheta).array() += turned_rad * turned_rad;
    trusted.covariance.diagonal().segment<3>(kPos).array() += flown_m * flown_m;
}

void Estimator::Impl::begin_on_new_clock() {
    // By the cameras' clock, if that has gone on.
    widen_trusted(std::max((refused_samples.newest() - refused_samples.clock_begin()).seconds(),
                           (offered - trusted.stamp).seconds()));
    trusted.stamp = offered;
    imu.restart();
    frontend.reset();
    q_Bf_B.setIdentity();
    map.clear();
    doubt = {};
    summary = {};
    tracks = {};
    span = {};
    phase = Phase::kEmpty;
    rest_claim = RestClaim::kNone;
    rests = reset_wanted = has_carried = is_bent = false;
    has_frame = has_primary = false;
    refused_samples = refused_frames = {};
    lost_time_s = 0.0;
    monitor.reset();
}

}  // namespace facet
