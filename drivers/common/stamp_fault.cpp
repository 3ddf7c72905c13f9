// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/common/stamp_fault.h"

namespace facet {
namespace {

/// A sample cannot have come after it was read; this much is the noise of reading two clocks.
constexpr Duration kClockNoise = Duration::from_seconds(0.001);
constexpr Duration kOldest = Duration::from_seconds(10.0);

}  // namespace

Timestamp now_by(const Clock& clock, ClockDomain domain) {
    return domain == ClockDomain::kRealtime ? clock.read_pair().realtime : clock.now();
}

const char* stamp_fault(Timestamp stamp, const Clock& clock, ClockDomain domain) {
    if (domain != ClockDomain::kMonotonic && domain != ClockDomain::kRealtime) {
        return nullptr;
    }
    const Timestamp now = now_by(clock, domain);
    if (stamp > now + kClockNoise) {
        return "stamps in the future";
    }
    return stamp < now - kOldest ? "stamps of long ago" : nullptr;
}

const char* delivery_fault(const SampleStamps& stamps, const Clock& clock, ClockDomain domain, IncreasingStamps& order,
                           std::uint64_t& refused) {
    if (const char* const fault = stamp_fault(stamps.given, clock, domain)) {
        ++refused;
        return fault;
    }
    return order.allows(stamps.delivered, refused) ? nullptr : "stamps that do not increase";
}

}  // namespace facet
