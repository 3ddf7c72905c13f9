// SPDX-License-Identifier: BSD-2-Clause
// Tries a vehicle's hardware and reports in words what works and what does not.
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

/// Starts each device, listens to it for that long, and stops it again. Writes only a probe file, into the log folder.
/// Heap; thread-bound.
std::vector<ProbeLine> dry_run(Hardware& hardware, Clock& clock, const Vehicle& vehicle, Duration listen);

/// One line for each, such as "ok        device:       text".
std::string to_text(const std::vector<ProbeLine>& lines);

}  // namespace facet
