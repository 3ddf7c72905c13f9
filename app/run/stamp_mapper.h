// SPDX-License-Identifier: BSD-2-Clause
// Maps the stamps of one source to the pipeline's clock.
#pragma once

#include "drivers/sync/clock_map.h"
#include "platform/port/clock.h"

namespace facet {

/// Monotonic stamps pass unchanged. Wall-clock stamps are mapped by pairs of both host clocks, read together some
/// thirty times a second; stamps of hardware and devices by pairs of stamp and arrival, of which those with little
/// delay count most. Thread-bound. No heap.
class StampMapper {
public:
    StampMapper(const Clock& clock, ClockDomain domain);

    /// To be called for every sample as it arrives.
    /// @return kNotReady until there are enough pairs, kOutOfOrder if the result is not after the one before, kCorrupt
    ///         if it lies in the future: drop the sample
    Status map(Timestamp& stamp);

private:
    static ClockMapOptions options_for(ClockDomain domain);

    const Clock& clock_;
    ClockDomain domain_;
    ClockMap clock_map_;
    Timestamp next_pair_;
};

}  // namespace facet
