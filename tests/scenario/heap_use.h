// SPDX-License-Identifier: BSD-2-Clause
// Heap calls of estimator, mesher and plane finder on a recorded flight.
#pragma once

#include <cstdint>
#include <string>

#include "estimator/frontend/frontend_config.h"
#include "estimator/window/regularity_config.h"

namespace facet::test {

struct HeapUse {
    int frames = 0;
    int keyframes = 0;
    int planes = 0;                 ///< told at the last keyframe
    std::uint64_t allocations = 0;  ///< by samples and frames, from the first one on
    std::string first;              ///< call stack of the first allocation
};

/// Flies an EuRoC/ASL log through the pipeline that replay and a live run share.
HeapUse measure_heap(const std::string& log, RegularityMode mode, FrontendBackend backend = FrontendBackend::kOwn);

}  // namespace facet::test
