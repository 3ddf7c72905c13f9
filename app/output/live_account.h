// SPDX-License-Identifier: BSD-2-Clause
// What only a live run has to account for: sources, drops, latency, and what the system refused.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "app/support/named_counter.h"
#include "platform/port/source.h"

namespace facet {

/// One source at the end of a run.
struct SourceAccount {
    std::string name;
    SourceCounters counters;
    std::uint64_t rejected = 0;  ///< samples that found the queue to the estimator full
    std::uint64_t unmapped = 0;  ///< samples whose stamp could not be brought onto the pipeline's clock
};

struct LiveAccount {
    double duration_s = 0.0;
    std::vector<double> latency_ms;      ///< from a frame's exposure midpoint until sinks have a pose with it, newest
    std::uint64_t poses = 0;             ///< given to the sinks
    std::uint64_t overruns = 0;          ///< frames whose processing took longer than a period of the cameras
    std::vector<NamedCounter> drops;     ///< frames and outputs dropped, by reason
    std::vector<NamedCounter> findings;  ///< of the synchroniser
    std::vector<SourceAccount> sources;
    std::vector<std::string> refusals;  ///< by the system, in words
};

}  // namespace facet
