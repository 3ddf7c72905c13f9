// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/stamp_mapper.h"

namespace facet {
namespace {

/// So often that a step of the wall clock, which takes five pairs to be believed, is followed within 0.15 s.
constexpr Duration kPairPeriod = Duration::from_seconds(0.03);
/// How far in the future a stamp may seem to be, by the estimate's error.
constexpr Duration kAhead = Duration::from_seconds(0.005);

}  // namespace

ClockMapOptions StampMapper::options_for(ClockDomain domain) {
    ClockMapOptions options;
    if (domain == ClockDomain::kHardware || domain == ClockDomain::kDevice) {
        options.one_sided = true;
        options.pair_sigma_s = 200e-6;  // how much the delay of a waking thread varies
        options.drift_sigma = domain == ClockDomain::kDevice ? 0.02 : options.drift_sigma;
    }
    return options;
}

StampMapper::StampMapper(const Clock& clock, ClockDomain domain)
    : clock_(clock), domain_(domain), clock_map_(options_for(domain)), next_pair_(clock.now()) {}

Status StampMapper::map(Timestamp& stamp) {
    if (domain_ == ClockDomain::kMonotonic) {
        return Status::kOk;
    }
    if (domain_ != ClockDomain::kRealtime) {
        (void)clock_map_.add(stamp, clock_.now());  // outliers are counted there
    } else if (clock_.now() >= next_pair_) {
        const ClockPair pair = clock_.read_pair();
        (void)clock_map_.add(pair.realtime, pair.monotonic);
        next_pair_ = clock_.now() + kPairPeriod;
    }
    Timestamp mapped;
    FACET_TRY(clock_map_.map(stamp, clock_.now() + kAhead, mapped));
    stamp = mapped;
    return Status::kOk;
}

}  // namespace facet
