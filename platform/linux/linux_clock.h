// SPDX-License-Identifier: BSD-2-Clause
// The clocks of Linux.
#pragma once

#include "platform/port/clock.h"

namespace facet {

/// CLOCK_MONOTONIC and CLOCK_REALTIME. Thread-safe. No heap.
class LinuxClock final : public Clock {
public:
    Timestamp now() const override;
    /// The tightest of five readings of monotonic, realtime, monotonic.
    ClockPair read_pair() const override;
    void sleep_until(Timestamp until) override;
};

}  // namespace facet
