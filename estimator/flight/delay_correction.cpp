// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/flight/delay_correction.h"

#include <algorithm>
#include <cmath>

namespace facet {
namespace {

// A delay is found anew if the one believed is off by this and by so many standard deviations.
constexpr double kLeastDelay_s = 8e-3;
constexpr double kCertain = 5.0;
constexpr double kFar = 3.0;              // standard deviations of what is given
constexpr double kSettledSigma_s = 1e-3;  // and then the search ends

}  // namespace

bool DelayCorrection::is_open(double offset_s, double sigma_s, bool is_tracking, bool has_depths) const {
    return !is_settled_ && has_depths && (!is_tracking || std::abs(offset_s) > kFar * sigma_s);
}

bool DelayCorrection::propose(const ImageDelay& off, double delay_s) {
    const bool is_certain = std::abs(off.value_s) > std::max(kLeastDelay_s, kCertain * off.sigma_s);
    if (is_certain) {
        proposed_s_ = delay_s + off.value_s;
    }
    return is_certain;
}

std::optional<double> DelayCorrection::accept(double delay_s) {
    if (!proposed_s_) {
        return std::nullopt;
    }
    search_.reset();
    found_s_ = *proposed_s_;
    proposed_s_.reset();
    return found_s_ - delay_s;
}

std::optional<double> DelayCorrection::step(const ImuBuffer& imu, double delay_s, double claimed_s) {
    ImageDelay found;
    if (!ok(search_.solve(imu, found))) {
        return std::nullopt;
    }
    const double off_s = found.value_s - delay_s;
    if (std::abs(off_s) < std::max(kLeastDelay_s, kCertain * std::hypot(found.sigma_s, claimed_s))) {
        is_settled_ = found.sigma_s < kSettledSigma_s;
        return std::nullopt;
    }
    is_settled_ = true;
    found_s_ = found.value_s;
    return off_s;
}

}  // namespace facet
