// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/values/refused_run.h"

namespace facet {

void RefusedRun::add(Timestamp stamp) {
    const bool goes_on = !is_empty_ && stamp > newest_ && (stamp - newest_).seconds() <= kStep_s;
    clock_begin_ = goes_on ? clock_begin_ : stamp;
    covered_ = goes_on ? covered_ + (stamp - newest_) : covered_;
    newest_ = stamp;
    is_empty_ = false;
}

double RefusedRun::take_s() {
    const double covered_s = covered_.seconds();
    covered_ = {};
    is_empty_ = true;
    return covered_s;
}

}  // namespace facet
