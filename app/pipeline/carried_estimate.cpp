// SPDX-License-Identifier: BSD-2-Clause
#include "app/pipeline/carried_estimate.h"

namespace facet {

void CarriedEstimate::correct(Status status, const Estimate& estimate, const Belief& belief) {
    if (status == Status::kNotReady) {
        return;  // the frame comes again
    }
    const Health health = estimate.health;
    if (ok(status) && health.state == TrackingState::kInit) {
        carrier_.forget();
    } else if (ok(status) && is_finite(belief)) {
        if (health.reset_counter != newest_.health.reset_counter) {
            carrier_.forget();
        }
        if (ok(carrier_.correct(belief))) {
            newest_ = estimate;
            gauge_ = estimate.covariance - belief.covariance.topLeftCorner<9, 9>();
        }
    }
    newest_.health = health;
}

Estimate CarriedEstimate::estimate() const {
    Estimate estimate = newest_;
    estimate.stamp = carrier_.stamp();
    estimate.state = carrier_.state();
    estimate.covariance = carrier_.covariance().topLeftCorner<9, 9>() + gauge_;
    return estimate;
}

}  // namespace facet
