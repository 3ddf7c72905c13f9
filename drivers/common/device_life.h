// SPDX-License-Identifier: BSD-2-Clause
// Opens a source's device, notices its outages and reopens it after a pause.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "drivers/common/retry_gate.h"
#include "platform/base/status.h"
#include "platform/port/clock.h"
#include "platform/port/source.h"

namespace facet {

/// What a DeviceLife opens and closes; a source implements it for its device.
class Reopenable {
public:
    /// Opens and configures the device. What it has opened when it fails is closed by the caller.
    /// @param problem  set on failure: what is wrong, with the device's name
    virtual Status open(std::string& problem) = 0;
    /// Closes the device; nothing happens if it is closed already.
    virtual void close() = 0;

protected:
    ~Reopenable() = default;
};

/// The life cycle that Source promises, for any device:
///   stopped  --start()-->  open  --fail(), silence-->  waiting  --next(), once every retry period-->  open
/// An error is counted when an outage begins, a recovery when a good sample ends it. A source's next() is one call of
/// next(), so that whatever it ends with but a sample counts as silence: nothing there, samples that are bad, stamps
/// that are refused.
/// Thread-bound. Heap for problem texts only.
class DeviceLife {
public:
    /// Everything is borrowed and must outlive this object.
    /// @param counters  samples delivered, errors and recoveries are counted here
    /// @param silence  without a good sample for this long the device counts as silent; zero: never
    DeviceLife(Reopenable& device, const Clock& clock, Duration retry_period, SourceCounters& counters,
               Duration silence = {})
        : device_(device), clock_(clock), counters_(counters), retry_(retry_period), silence_(silence) {}
    DeviceLife(const DeviceLife&) = delete;
    DeviceLife& operator=(const DeviceLife&) = delete;

    /// Opens the device and forgets earlier problems. kOk if started already.
    /// @return on failure the status of Reopenable::open; stopped then
    Status start();
    /// Closes the device, whatever its state. An outage that has not ended is not counted as a recovery.
    void stop();

    /// One call of a source's next(): reopens a device that has failed if an attempt is due, takes a sample from one
    /// that is open, and judges its silence. A device that has been without a good sample for too long, as after a
    /// brown-out that reset it, is closed, to be reopened in the next call if the last attempt is a retry period ago;
    /// one that was just opened has kFirstSample at least.
    /// @param name  the device's, for the problem
    /// @param take  Status(): kOk with a good sample, which ends an outage
    /// @return what `take` returns; kNotReady if stopped, or waiting for the next attempt; kIo if this attempt failed,
    ///         or if the device was closed for its silence
    template <class Take>
    Status next(const std::string& name, Take take) {
        FACET_TRY(check());
        const Status taken = take();
        if (ok(taken)) {
            works();
            ++counters_.delivered;
            return taken;
        }
        return taken != Status::kIo && is_silent(name) ? Status::kIo : taken;
    }
    /// A sample came that was of no use. @param why  static words, for the problem if no good one follows
    void refuse(const char* why) { refused_for_ = why; }
    /// A good sample came; next() says so of those that it returns.
    void works();
    /// The device has failed: closes it. @return kIo
    Status fail(std::string problem);
    /// The device has failed but recovers by itself: it stays open. @return kIo
    Status fail_without_closing(std::string problem);

    static constexpr Duration kFirstSample = Duration::from_seconds(2.0);

    /// From a successful start() to stop(), whether or not the device is failing.
    bool is_started() const { return state_ != State::kStopped; }
    /// The last problem since start(), also after its outage has ended; if there has been none, why no good sample has
    /// come; empty if nothing is wrong.
    std::string_view problem() const {
        const bool is_quiet = problem_.empty() && refused_for_ != nullptr;
        return is_quiet ? std::string_view(refused_for_) : std::string_view(problem_);
    }

private:
    enum class State : std::uint8_t { kStopped, kOpen, kWaiting };

    Status open();
    Status check();
    bool is_silent(const std::string& name);

    Reopenable& device_;
    const Clock& clock_;
    SourceCounters& counters_;
    RetryGate retry_;
    State state_ = State::kStopped;
    bool is_failing_ = false;
    Duration silence_;
    Timestamp heard_;                    ///< when the last good sample came, or the device was opened
    bool any_heard_ = false;             ///< a good sample since it was opened
    const char* refused_for_ = nullptr;  ///< since the last good sample
    std::string problem_;
};

}  // namespace facet
