// SPDX-License-Identifier: BSD-2-Clause
// Where the time comes from outside the estimator: clock domains and a clock that can be replaced in tests.
#pragma once

#include <cstdint>

#include "platform/base/timestamp.h"

namespace facet {

/// Which clock a stamp was read from. Stamps of different domains must be mapped before they are compared.
enum class ClockDomain : std::uint8_t {
    kMonotonic,  ///< the kernel's monotonic clock: V4L2 buffers, GPIO edges by default. The clock of the pipeline
    kRealtime,   ///< wall-clock time, may step: SocketCAN's software stamps
    kHardware,   ///< a hardware clock of the host: GPIO edges stamped by a timestamping engine, CAN controllers
    kDevice,     ///< a counter inside the sensor
};

constexpr const char* to_string(ClockDomain domain) {
    switch (domain) {
        case ClockDomain::kMonotonic: return "monotonic";
        case ClockDomain::kRealtime: return "realtime";
        case ClockDomain::kHardware: return "hardware";
        case ClockDomain::kDevice: return "device";
    }
    return "unknown";
}

/// Two host clocks read at one instant; `uncertainty` is half of the span within which both were read.
struct ClockPair {
    Timestamp monotonic;
    Timestamp realtime;
    Duration uncertainty;
};

/// The host's clocks. Thread-safe. No heap.
class Clock {
public:
    virtual ~Clock() = default;

    /// Now, in the monotonic domain.
    virtual Timestamp now() const = 0;
    /// Both clocks at one instant, for mapping one onto the other.
    virtual ClockPair read_pair() const = 0;
    /// Returns at or after `until` (monotonic); at once if that is past. Signals do not end it early.
    virtual void sleep_until(Timestamp until) = 0;

    void sleep(Duration span) { sleep_until(now() + span); }
};

}  // namespace facet
