// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/sync/clock_map.h"

#include <algorithm>
#include <cmath>

#include "platform/base/assert.h"

namespace facet {
namespace {

/// An arrival is never early: one that is earlier than this foretold tells that the offset was too late.
constexpr double kEarlySigmas = 2.0;

}  // namespace

void ClockMap::restart(Timestamp source, Timestamp host) {
    base_ns_ = host.ns - source.ns;
    offset_s_ = 0.0;
    last_source_ = source;
    p_oo_ = options_.pair_sigma_s * options_.pair_sigma_s;
    p_od_ = 0.0;
    // The drift estimate survives a step of the offset.
    p_dd_ = std::max(p_dd_, used_ == 0 ? options_.drift_sigma * options_.drift_sigma : 0.0);
    used_ = std::max(used_, 1);
    outliers_in_a_row_ = 0;
}

Status ClockMap::add(Timestamp source, Timestamp host) {
    if (counters_.pairs > 0 && source <= last_seen_) {
        // The source clock was set back: a new epoch begins.
        if (last_seen_ - source > options_.step) {
            last_seen_ = source;
            ++counters_.steps;
            restart(source, host);
        }
        return Status::kOutOfOrder;
    }
    last_seen_ = source;
    ++counters_.pairs;
    if (used_ == 0) {
        restart(source, host);
        return Status::kOk;
    }
    const double dt_s = (source - last_source_).seconds();
    const double predicted_s = offset_s_ + drift_ * dt_s;
    const double residual_s = static_cast<double>(host.ns - source.ns - base_ns_) * 1e-9 - predicted_s;
    const double limit_s = options_.step.seconds();
    const bool late_only = options_.one_sided && residual_s > 0.0;
    if (std::abs(residual_s) > limit_s) {
        ++counters_.outliers;
        if (++outliers_in_a_row_ >= options_.pairs_for_step) {
            ++counters_.steps;
            restart(source, host);
        }
        return Status::kCorrupt;
    }
    outliers_in_a_row_ = 0;
    p_oo_ += 2.0 * dt_s * p_od_ + dt_s * dt_s * p_dd_;
    p_od_ += dt_s * p_dd_;
    p_dd_ += options_.drift_walk * options_.drift_walk * dt_s;
    double sigma_s = options_.pair_sigma_s;
    if (late_only) {
        // Nearly all of a positive residual is delay.
        sigma_s *= 10.0 * (1.0 + residual_s / options_.pair_sigma_s);
    }
    const double s = p_oo_ + sigma_s * sigma_s;
    if (options_.one_sided && residual_s < -kEarlySigmas * std::sqrt(s)) {
        // The pairs before were all late, which says nothing of drift.
        offset_s_ = predicted_s + residual_s;
        p_oo_ = options_.pair_sigma_s * options_.pair_sigma_s;
        p_od_ = 0.0;
    } else {
        const double k_o = p_oo_ / s;
        const double k_d = p_od_ / s;
        offset_s_ = predicted_s + k_o * residual_s;
        drift_ += k_d * residual_s;
        p_dd_ -= k_d * p_od_;
        p_od_ -= k_o * p_od_;
        p_oo_ -= k_o * p_oo_;
    }
    last_source_ = source;
    ++used_;
    return Status::kOk;
}

Timestamp ClockMap::to_host(Timestamp source) const {
    FACET_ASSERT(ready());
    const double shift_s = offset_s_ + drift_ * (source - last_source_).seconds();
    return Timestamp{source.ns + base_ns_ + std::llround(shift_s * 1e9)};
}

Status ClockMap::map(Timestamp source, Timestamp latest, Timestamp& host) {
    if (!ready()) {
        return Status::kNotReady;
    }
    const Timestamp mapped = to_host(source);
    if (mapped > latest) {
        return Status::kCorrupt;
    }
    if (any_mapped_ && mapped <= last_mapped_) {
        return Status::kOutOfOrder;
    }
    any_mapped_ = true;
    last_mapped_ = mapped;
    host = mapped;
    return Status::kOk;
}

}  // namespace facet
