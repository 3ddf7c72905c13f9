// SPDX-License-Identifier: BSD-2-Clause
// What the estimator does when time is on no clock, because one has gone back, or when it has passed without a program:
// it begins anew from where it was.
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
// A delay of images is found anew if the one believed is off by this and by so many standard deviations.
constexpr double kLeastDelay_s = 8e-3;
constexpr double kCertain = 5.0;
constexpr double kFar = 3.0;              // standard deviations of what is given
constexpr double kSettledSigma_s = 1e-3;  // and then the search ends

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

void Estimator::Impl::fuse_trusted_bias() {
    Eigen::Matrix<double, 6, 1> difference;
    difference << trusted.state.bias.gyro - now.state.bias.gyro, trusted.state.bias.accel - now.state.bias.accel;
    const Eigen::Matrix<double, kStateDim, 6> shared = now.covariance.rightCols<6>();
    const Eigen::Matrix<double, 6, 6> innovation =
        now.covariance.bottomRightCorner<6, 6>() + trusted.covariance.bottomRightCorner<6, 6>();
    const Eigen::Matrix<double, kStateDim, 6> gain = innovation.llt().solve(shared.transpose()).transpose();
    now.state = now.state.box_plus(gain * difference);
    now.covariance = (now.covariance - gain * shared.transpose()).eval();
    now.covariance = (0.5 * (now.covariance + now.covariance.transpose())).eval();
}

KeptState Estimator::keep() const {
    KeptState kept;
    kept.state = impl_->now.state;
    StateCovariance covariance = impl_->now.covariance;
    covariance.topLeftCorner<9, 9>() = impl_->reported_covariance();
    kept.sigma = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
    kept.calibration = calibration();
    if (!impl_->window.has_factor()) {  // nothing has been found yet, but by an earlier program
        kept.calibration.sigma = impl_->calibration_sigma;
    }
    return kept;
}

Status Estimator::resume(const KeptState& kept, double elapsed_s) {
    constexpr double kInflation = 2.0;
    Belief belief;
    belief.state = kept.state;
    belief.covariance.diagonal() = kept.sigma.cwiseAbs2();
    const double norm = kept.state.q_W_B.norm();
    if (!is_finite(belief) || !(kept.sigma.array() > 0.0).all() || !(std::abs(norm - 1.0) < 1e-3) ||
        !(elapsed_s >= 0.0) || !std::isfinite(elapsed_s)) {
        return Status::kInvalidArgument;
    }
    if (!kept.calibration.sigma.isZero(0.0)) {
        FACET_TRY(impl_->window.resume_calibration(kept.calibration.correction, kept.calibration.sigma));
        impl_->calibration_sigma = kInflation * kept.calibration.sigma;
        impl_->update_corrections();
    }
    belief.state.q_W_B.normalize();
    belief.covariance.bottomRightCorner<6, 6>() *= kInflation * kInflation;
    impl_->trusted = belief;
    impl_->has_trusted = true;
    impl_->widen_trusted(elapsed_s);
    return Status::kOk;
}

void Estimator::Impl::begin_on_new_clock() {
    // By the cameras' clock, if that has gone on.
    widen_trusted(std::max((refused_samples.newest() - refused_samples.clock_begin()).seconds(),
                           (offered - trusted.stamp).seconds()));
    trusted.stamp = offered;
    imu.restart();
    begin_like_first();
}

bool Estimator::Impl::seeks_delay() const {
    const bool is_far = std::abs(window.calibration().time_offset_s) > kFar * config.calibration.time_offset_sigma_s;
    return config.calibration.estimate_time_offset && !is_delay_settled &&
           (is_far || monitor.state() != TrackingState::kTracking);
}

void Estimator::Impl::settle_delay() {
    ImageDelay found;
    imu.exchange_read();  // of the readings that are in doubt as well
    const Status status = delay_search.solve(imu, found);
    imu.exchange_read();
    if (!ok(status)) {
        return;
    }
    const double off_s = found.value_s - image_delay_s();
    const double claimed_s = monitor.is_usable() ? calibration_sigma(kTimeOffset) : 0.0;
    if (std::abs(off_s) < std::max(kLeastDelay_s, kCertain * std::hypot(found.sigma_s, claimed_s))) {
        is_delay_settled = found.sigma_s < kSettledSigma_s;
        return;
    }
    is_delay_settled = true;
    widen_trusted(std::abs(off_s));
    found_delay_s = found.value_s;
    window.forget_calibration();
    forget_corrections();
    begin_like_first();
}

void Estimator::Impl::begin_like_first() {
    // A sensor that has begun anew may have other biases; after a wrong delay they are wrong, too.
    StateCovariance& c = trusted.covariance;
    c.diagonal().segment<3>(kBiasGyro).array() += std::pow(config.initializer.gyro_bias_sigma_rad_per_s, 2);
    c.diagonal().segment<3>(kBiasAccel).array() += std::pow(config.initializer.accel_bias_sigma_m_per_s2, 2);
    frontend.reset();
    q_Bf_B.setIdentity();
    map.clear();
    waiting.is_set = false;
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
