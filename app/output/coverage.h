// SPDX-License-Identifier: BSD-2-Clause
// Whether a run has estimated as much of its log as it should have, from readings that agree.
#pragma once

#include <string>

#include "app/output/summary.h"

namespace facet {

inline constexpr double kMinCoverage = 0.8;  ///< by default

/// What is wrong with the share of frames that have an estimate, and where the others have stayed, in one sentence;
/// empty if it is enough: `min_coverage` of the frames since the first estimate, and half as much of all frames. A run
/// without any estimate is described too, whatever the minimum. Reentrant. Heap.
std::string describe_lost_coverage(const RunSummary& summary, double min_coverage);

/// That images and inertial samples have contradicted each other in most frames since the first estimate, in one
/// sentence; empty if not: then a sensor, or how it is mounted, is wrong, and nothing of the run is of use. Reentrant.
/// Heap.
std::string describe_contradiction(const RunSummary& summary);

}  // namespace facet
