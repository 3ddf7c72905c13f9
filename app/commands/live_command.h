// SPDX-License-Identifier: BSD-2-Clause
// What commands on live sensors have in common around their threads.
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "app/config/vehicle.h"
#include "app/run/flight_log.h"
#include "app/run/hardware.h"
#include "drivers/common/retry_gate.h"
#include "platform/port/clock.h"

namespace facet {

/// The time between two calls of what a live command does beside its threads.
inline constexpr Duration kLiveTick = Duration::from_seconds(0.05);

/// Starts the trigger pulses, if this computer makes them. Thread-bound.
class PulseStarter {
public:
    /// Everything is borrowed.
    PulseStarter(Hardware& hardware, const Vehicle& vehicle, const Clock& clock)
        : hardware_(hardware), vehicle_(vehicle), clock_(clock) {}

    /// To be called when the cameras are ready. Prints what the system has refused as warnings. Throws InputError if
    /// the pulses cannot be made, unless the program was restarted in flight: then tick() tries again.
    /// @param refusals  of the threads
    void begin(std::vector<std::string> refusals, bool is_in_flight = false);
    /// Tries once a second if that is needed, and says when it works.
    void tick();

private:
    Hardware& hardware_;
    const Vehicle& vehicle_;
    const Clock& clock_;
    bool is_awaited_ = false;
    RetryGate retry_{Duration::from_seconds(1.0)};
};

/// Ends them, and warns of those that were skipped.
void end_pulses(Hardware& hardware);

/// Returns once `stop` is set, the duration is over, or `tick`, which is called after each kLiveTick, gives false.
/// @param duration_s  zero: without end
void wait_live(Clock& clock, const std::atomic<bool>& stop, double duration_s, const std::function<bool()>& tick);

/// Prints the problem, if there is one. @return the exit code of a command that ran
int exit_code_for(const std::string& problem);

inline constexpr const char* kLogFormHelp =
    "Form of the log: folder (mav0, EuRoC/ASL) or mcap (flight.mcap, for Foxglove too; facet run adds its estimates)";
/// Throws InputError if it is none of kLogFormNames.
LogForm parse_log_form(const std::string& text);

/// Throws InputError if it is negative.
void require_duration(double duration_s);

}  // namespace facet
