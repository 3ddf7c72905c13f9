// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/mavlink/timesync_filter.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "platform/base/assert.h"

namespace facet {
namespace {

constexpr double kSigma_s = 50e-6;     // of a block without jitter
constexpr double kSpreadShare = 1.5;   // uniform jitter of J makes the middle err by 0.7 J, the spread 0.8 J, per block
constexpr double kDriftSigma = 50e-6;  // of two crystals
constexpr double kDriftWalk = 1e-7;    // 1/sqrt(s)
constexpr double kReadySigma_s = 0.4e-3;
constexpr double kSlack_s = 1e-3;  // of a contradiction

}  // namespace

void TimesyncFilter::restart() {
    ++steps_;
    any_ = is_running_ = is_ready_ = false;
    filled_ = 0;
    contradictions_ = 0;
    drift_ = 0.0;
}

bool TimesyncFilter::contradicts(const Exchange& exchange) const {
    if (!is_running_) {
        return false;
    }
    const double dt = (exchange.middle - last_).seconds();
    const double offset = offset_s_ + drift_ * dt;
    const double slack = kSlack_s + 5.0 * std::sqrt(p_oo_ + dt * (2.0 * p_od_ + dt * p_dd_));
    return offset < exchange.lower_s - slack || offset > exchange.upper_s + slack;
}

Status TimesyncFilter::add(Timestamp sent, Timestamp received, Timestamp remote) {
    const Duration round_trip = received - sent;
    if (round_trip < Duration{} || round_trip > kMaxRoundTrip || (any_ && sent <= last_sent_)) {
        return Status::kInvalidArgument;
    }
    if (!any_) {
        any_ = true;
        base_ns_ = remote.ns - sent.ns;
    }
    last_sent_ = sent;
    const auto beyond_base = [this, remote](Timestamp own) {
        return static_cast<double>(remote.ns - own.ns - base_ns_) * 1e-9;
    };
    const Exchange exchange{sent + Duration{round_trip.ns / 2}, beyond_base(received), beyond_base(sent)};
    if (contradicts(exchange)) {
        if (++contradictions_ >= kForStep) {
            restart();
        }
        return Status::kCorrupt;
    }
    contradictions_ = 0;
    block_[filled_++] = exchange;
    if (filled_ == kBlock) {
        finish_block();
        filled_ = 0;
    }
    return Status::kOk;
}

void TimesyncFilter::finish_block() {
    const Timestamp at = block_.back().middle;
    double lower = -std::numeric_limits<double>::max();
    double upper = std::numeric_limits<double>::max();
    double sum = 0.0;
    double least = std::numeric_limits<double>::max();
    for (const Exchange& exchange : block_) {
        const double drifted = drift_ * (at - exchange.middle).seconds();
        lower = std::max(lower, exchange.lower_s + drifted);
        upper = std::min(upper, exchange.upper_s + drifted);
        const double trip = exchange.upper_s - exchange.lower_s;
        sum += trip;
        least = std::min(least, trip);
    }
    if (lower > upper + kSlack_s) {
        restart();  // the clock has stepped within the first block
        return;
    }
    const double sigma = kSigma_s + kSpreadShare * (sum / kBlock - least) / kBlock;
    const double measured = 0.5 * (lower + upper);
    if (!is_running_) {
        is_running_ = true;
        offset_s_ = measured;
        p_oo_ = sigma * sigma;
        p_od_ = 0.0;
        p_dd_ = kDriftSigma * kDriftSigma;
    } else {
        const double dt = (at - last_).seconds();
        const double p_oo = p_oo_ + dt * (2.0 * p_od_ + dt * p_dd_);
        const double p_od = p_od_ + dt * p_dd_;
        const double p_dd = p_dd_ + kDriftWalk * kDriftWalk * dt;
        const double predicted = offset_s_ + drift_ * dt;
        const double k_o = p_oo / (p_oo + sigma * sigma);
        const double k_d = p_od / (p_oo + sigma * sigma);
        offset_s_ = predicted + k_o * (measured - predicted);
        drift_ += k_d * (measured - predicted);
        p_oo_ = (1.0 - k_o) * p_oo;
        p_od_ = (1.0 - k_o) * p_od;
        p_dd_ = p_dd - k_d * p_od;
    }
    last_ = at;
    is_ready_ = is_ready_ || sigma_s() < kReadySigma_s;
}

Timestamp TimesyncFilter::to_remote(Timestamp own) const {
    FACET_ASSERT(ready());
    const double offset_s = offset_s_ + drift_ * (own - last_).seconds();
    return {own.ns + base_ns_ + static_cast<std::int64_t>(std::llround(offset_s * 1e9))};
}

/// With d = own - last: remote - base - last = d + offset + drift d.
Timestamp TimesyncFilter::to_own(Timestamp remote) const {
    FACET_ASSERT(ready());
    const double beyond_s = static_cast<double>(remote.ns - base_ns_ - last_.ns) * 1e-9;
    return {last_.ns + static_cast<std::int64_t>(std::llround((beyond_s - offset_s_) / (1.0 + drift_) * 1e9))};
}

double TimesyncFilter::sigma_s() const { return is_running_ ? std::sqrt(p_oo_) : 0.0; }

}  // namespace facet
