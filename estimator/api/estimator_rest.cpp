// SPDX-License-Identifier: BSD-2-Clause
// Whether the vehicle stands, by inertial samples and images, and what that makes of the state.
#include "estimator/api/estimator_impl.h"
#include "estimator/factors/rest_factor.h"
#include "estimator/imu/static_init.h"
#include "estimator/imu/stationarity.h"

namespace facet {
namespace {

// The median of fewer tracks says nothing of rest.
constexpr int kRestTracks = 8;
// A rest that images have confirmed for this long was one, however smoothly the vehicle takes off later: what moves by
// less than half a pixel in that time at 10 m flies less than 4 cm/s.
constexpr double kSettled_s = 0.29;

}  // namespace

void Estimator::Impl::judge_rest(bool image_is_still) {
    Stationarity stationarity;
    const Status known = measure_stationarity(imu, now.stamp, {config.imu_noise, now.state.bias, gravity_m_per_s2},
                                              config.stationarity, stationarity);
    rests = rests && image_is_still && ok(known) && stationarity.may_be_at_rest;
}

void Estimator::Impl::judge_rest_claim() {
    const bool is_claimed = rest_claim == RestClaim::kOpen || rest_claim == RestClaim::kSeen;
    if (!is_claimed || tracks.image != ImageState::kUsable || tracks.tracked < kRestTracks) {
        return;
    }
    InitialState again;
    if (!ok(initialize_state(imu, now.stamp, gravity_m_per_s2, config.initializer, again)) || !again.is_still) {
        rest_claim = RestClaim::kNone;  // it moves off, and the inertial samples tell how
    } else if (tracks.rest_disparity_px > config.frontend.still_disparity_px) {
        rest_claim = RestClaim::kRefuted;
    } else {
        const bool is_settled = (now.stamp - window_began).seconds() > kSettled_s;
        rest_claim = is_settled ? RestClaim::kNone : RestClaim::kSeen;
    }
}

void Estimator::Impl::hold_still() {
    const RestSigmas sigmas;
    now.state.q_W_B = newest.state.q_W_B;
    now.state.p_W_B = newest.state.p_W_B;
    now.state.v_W_B.setZero();
    now.covariance = newest.covariance;
    now.covariance.middleRows<3>(kVel).setZero();
    now.covariance.middleCols<3>(kVel).setZero();
    now.covariance.diagonal().segment<3>(kTheta).array() += sigmas.theta_rad * sigmas.theta_rad;
    now.covariance.diagonal().segment<3>(kPos).array() += sigmas.p_m * sigmas.p_m;
    now.covariance.diagonal().segment<3>(kVel).setConstant(sigmas.v_m_per_s * sigmas.v_m_per_s);
}

}  // namespace facet
