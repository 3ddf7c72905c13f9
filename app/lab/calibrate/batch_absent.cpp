// SPDX-License-Identifier: BSD-2-Clause
// In the place of batch.cpp where Ceres is not installed, or not wanted.
#include "app/lab/calibrate/batch.h"

namespace facet {

bool has_batch_solver() { return false; }

Status solve_batch(const RecordedFlight& /*flight*/, const BatchOptions& /*options*/, BatchResult& /*out*/) {
    return Status::kInvalidArgument;
}

}  // namespace facet
