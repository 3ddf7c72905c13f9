// SPDX-License-Identifier: BSD-2-Clause
// What facet run does about its sinks beside their thread: opens them, keeps what the next program needs, reports.
#pragma once

#include <vector>

#include "app/run/hardware.h"
#include "app/run/reset_count.h"
#include "app/run/signing_time.h"

namespace facet {

/// Opens those that there are; the first pose of each has the counter that announces the jump. Throws InputError if one
/// cannot be opened, unless the program was restarted in flight: then it is waited for, and a warning says so. An
/// address that cannot be is a mistake in flight, too.
std::vector<OdometrySink*> open_sinks(Hardware& hardware, const ResetCount& resets, bool is_in_flight);

/// Keeps the counter of poses that are sent, so that a restarted program can announce its jump.
void keep_resets(Hardware& hardware, ResetCount& resets);

/// Keeps the time of signatures, and says once if the autopilot cannot understand what is sent.
void look_after(MavlinkLink& link, SigningTime& signing, bool& is_said);

/// After their thread has ended.
void print_sinks(Hardware& hardware);

}  // namespace facet
