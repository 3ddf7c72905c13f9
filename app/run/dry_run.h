// SPDX-License-Identifier: BSD-2-Clause
// Tries a vehicle's hardware and says in words what is right and what is wrong.
#pragma once

#include <string>
#include <vector>

#include "app/run/hardware.h"

namespace facet {

enum class Finding : std::uint8_t {
    kGood,
    kDoubtful,  ///< works, but not as configured or not as well as it could
    kWrong,     ///< a run cannot start, or would not estimate
};

/// One line of the report.
struct ProbeLine {
    Finding finding = Finding::kGood;
    std::string device;
    std::string text;
};

/// Starts each device, listens to it for `listen`, and stops it again. Writes nothing but a probe file into the log folder.
/// Heap; thread-bound.
std::vector<ProbeLine> dry_run(Hardware& hardware, Clock& clock, const Vehicle& vehicle, Duration listen);

/// "ok       device: text" and so on, a line each.
std::string to_text(const std::vector<ProbeLine>& lines);

}  // namespace facet
