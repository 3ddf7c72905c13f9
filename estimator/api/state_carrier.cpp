// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/api/state_carrier.h"

#include <cmath>

namespace facet {

void StateCarrier::configure(const ImuNoise& noise, const ImuLimits& limits, double gravity_m_per_s2,
                             double smoothing_s) {
    imu_.clear(noise.rate_hz, limits);
    noise_ = noise;
    limits_ = limits;
    smoothing_s_ = smoothing_s;
    refused_ = {};
    has_state_ = false;
    belief_ = {};
    since_ = Preintegration({}, gravity_m_per_s2);
    carried_ = {};
    taken_back_.setZero();
}

Status StateCarrier::add_imu(const ImuSample& sample, ImuAxisMask clipped) {
    Status status = imu_.push(sample, clipped);
    if (status == Status::kOutOfOrder && !imu_.has(sample)) {
        refused_.add(sample.stamp);
        if (refused_.is_clock()) {
            imu_.restart();
            has_state_ = false;
            status = imu_.push(sample, clipped);
        }
    }
    FACET_TRY(status);
    refused_ = {};
    if (!has_state_) {
        return Status::kOk;
    }
    replace_readings(belief_);
    if (!ok(imu_.integrate_between(carried_, sample.stamp, noise_, since_))) {
        has_state_ = false;  // the ring has lost what lies between: cannot happen from sample to sample
        return Status::kOk;
    }
    if (smoothing_s_ > 0.0) {
        taken_back_ *= std::exp(-(sample.stamp - carried_).seconds() / smoothing_s_);
    }
    carried_ = sample.stamp;
    return Status::kOk;
}

Status StateCarrier::correct(const Belief& belief) {
    if (has_state_ && belief.stamp < belief_.stamp) {
        return Status::kOutOfOrder;
    }
    if (imu_.empty() || imu_.newest() < belief.stamp) {
        return Status::kNotReady;
    }
    imu_.believe(belief.vibration);
    imu_.restore(belief.stamp, imu_.newest());
    replace_readings(belief);
    Preintegration since(belief.state.bias, since_.gravity_m_per_s2());
    since.set_scale(belief.imu_scale, false);
    FACET_TRY(imu_.integrate_between(belief.stamp, imu_.newest(), noise_, since));
    const NavState before = has_state_ ? state() : NavState{};
    const bool is_step = has_state_ && smoothing_s_ > 0.0;
    belief_ = belief;
    since_ = since;
    carried_ = imu_.newest();
    has_state_ = true;
    taken_back_ = is_step ? unsmoothed().box_minus_to(before).head<kBiasGyro>().eval() : Step::Zero().eval();
    return Status::kOk;
}

void StateCarrier::replace_readings(const Belief& belief) {
    if (belief.replaced.axes != 0) {
        imu_.set_replacement_noise(belief.replaced.noise);
        imu_.replace(belief.stamp, imu_.newest(), belief.replaced.axes, belief.replaced.motion);
    }
}

NavState StateCarrier::state() const {
    Eigen::Matrix<double, kStateDim, 1> d = Eigen::Matrix<double, kStateDim, 1>::Zero();
    d.head<kBiasGyro>() = taken_back_;
    return smoothing_s_ > 0.0 ? unsmoothed().box_plus(d) : unsmoothed();
}

}  // namespace facet
