// SPDX-License-Identifier: BSD-2-Clause
// Whether a source's device is failing, and why.
#pragma once

#include <string>
#include <utility>

#include "platform/base/status.h"
#include "platform/port/source.h"

namespace facet {

/// What every source of samples remembers of a failing device: an error is counted when an outage begins, a recovery when
/// it ends. Thread-bound. Heap for the words only.
struct Outage {
    std::string problem;  ///< words for the user; of the last outage too
    bool is_failing = false;

    void clear() {
        problem.clear();
        is_failing = false;
    }
    /// The device fails. @return kIo
    Status begin(std::string words, SourceCounters& counters) {
        problem = std::move(words);
        counters.errors += is_failing ? 0 : 1;
        is_failing = true;
        return Status::kIo;
    }
    /// A good sample came.
    void end(SourceCounters& counters) {
        counters.recoveries += is_failing ? 1 : 0;
        is_failing = false;
    }
};

}  // namespace facet
