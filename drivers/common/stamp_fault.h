// SPDX-License-Identifier: BSD-2-Clause
// Whether a stamp can be that of a sample that was read just now.
#pragma once

#include <cstdint>

#include "drivers/common/increasing_stamps.h"
#include "platform/port/clock.h"

namespace facet {

/// Now, by the clock that a domain's stamps are read from; the monotonic one's where the host has no such clock.
/// Reentrant. No heap.
Timestamp now_by(const Clock& clock, ClockDomain domain);

/// A sample cannot be of the future: believed and remembered, one such stamp would keep every later sample from being
/// delivered. Nor does a driver or a kernel keep one for more than ten seconds. To be asked of every stamp of a host's
/// clock before anything else is done with it; of other clocks nothing is known. Reentrant. No heap.
/// @return what is wrong, in words; nullptr if nothing is
const char* stamp_fault(Timestamp stamp, const Clock& clock, ClockDomain domain);

/// A sample's stamp as its driver gave it, and as it is to be delivered.
struct SampleStamps {
    Timestamp given;
    Timestamp delivered;
};

/// The same of a sample that is about to be delivered, whose stamp must also come after the last one's. What is wrong
/// is counted in `refused`. Call order.delivered() once the sample is delivered. Reentrant. No heap.
const char* delivery_fault(const SampleStamps& stamps, const Clock& clock, ClockDomain domain, IncreasingStamps& order,
                           std::uint64_t& refused);

}  // namespace facet
