// SPDX-License-Identifier: BSD-2-Clause
// Whether a stamp can be that of a sample that was read just now.
#pragma once

#include "platform/port/clock.h"

namespace facet {

/// A sample cannot be of the future: believed and remembered, one such stamp would keep every later sample from being
/// delivered. Nor does a driver or a kernel keep one for more than ten seconds. To be asked of every stamp of a host's
/// clock before anything else is done with it; of other clocks nothing is known. Reentrant. No heap.
/// @return what is wrong, in words; nullptr if nothing is
const char* stamp_fault(Timestamp stamp, const Clock& clock, ClockDomain domain);

}  // namespace facet
