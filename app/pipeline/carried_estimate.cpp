// SPDX-License-Identifier: BSD-2-Clause
#include "app/pipeline/carried_estimate.h"

namespace facet {

bool CarriedEstimate::add_imu(const ImuSample& sample, Estimate& estimate) {
    if (!ok(carrier_.add_imu(sample)) || !carrier_.has_state()) {
        return false;
    }
    estimate = newest_;
    estimate.stamp = carrier_.stamp();
    estimate.state = carrier_.state();
    estimate.covariance = carrier_.covariance().topLeftCorner<9, 9>();
    return true;
}

void CarriedEstimate::correct(const FrameResult& result, const Belief& belief) {
    if (result.status == Status::kNotReady) {
        return;  // the frame comes again
    }
    newest_ = result.estimate;
    if (!result.is_usable || !ok(carrier_.correct(belief))) {
        carrier_.forget();
    }
}

}  // namespace facet
