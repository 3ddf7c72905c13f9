// SPDX-License-Identifier: BSD-2-Clause
// What all sources of samples have in common: life cycle, counters, clock.
#pragma once

#include <cstdint>
#include <string_view>

#include "platform/base/status.h"
#include "platform/port/clock.h"

namespace facet {

/// What has happened in a source since construction.
struct SourceCounters {
    std::uint64_t delivered = 0;   ///< samples given to the caller
    std::uint64_t lost = 0;        ///< samples that the device made and that never arrived (gaps of its counter)
    std::uint64_t corrupt = 0;     ///< samples dropped for a wrong checksum, an error flag or impossible content
    std::uint64_t discarded = 0;   ///< good samples dropped on purpose: duplicates, or older than the latest requested
    std::uint64_t errors = 0;      ///< times the device or the kernel failed
    std::uint64_t recoveries = 0;  ///< times it worked again after that
};

/// A device that delivers samples. Usage:
///   FACET_TRY(source.start());
///   for (;;) switch (source.next(timeout, sample)) { ... }
///   source.stop();
/// Contract of `next` in every kind of source; tests/port_conformance holds all implementations to it:
///   kOk           a sample; stamps strictly increase from one to the next, also across stop and start, and none is of
///                 the future. After a clock other than the monotonic one was set back, they increase again
///   kNotReady     none within the timeout, or not started. A zero timeout never waits
///   kCorrupt      one sample was bad and is dropped and counted; go on
///   kIo           the device fails, or has given no good sample for too long; problem() says how. Go on calling: the
///                 source reopens it by itself, at most once every retry period, and counts a recovery
///   kEndOfStream  no more will come; and so from then on
/// On anything but kOk the sample is untouched. Thread-bound, but counters() may be read from any thread that may live
/// with a torn set of them. Heap only in the constructor and in start().
class Source {
public:
    virtual ~Source() = default;

    /// Opens and configures the device. kOk if started already.
    /// @return kInvalidArgument if the configuration or the device can never work, kIo if the system refused, kNotFound
    ///         if the device is not there; problem() has the words. May be called again.
    virtual Status start() = 0;
    /// Stops and closes; nothing if not started.
    virtual void stop() = 0;

    /// Clock of the stamps delivered.
    virtual ClockDomain clock() const = 0;
    virtual SourceCounters counters() const = 0;
    /// What went wrong last, in words with the device's name; empty if nothing has. Valid until the next call.
    virtual std::string_view problem() const = 0;
    /// What is not as it was asked for although the source works, in words, since start(); empty if all is.
    virtual std::string_view warning() const { return {}; }
};

}  // namespace facet
