// SPDX-License-Identifier: BSD-2-Clause
// Who sees the samples on their way to the estimator.
#pragma once

#include "drivers/sync/synchroniser.h"
#include "platform/base/range_sample.h"
#include "platform/base/samples.h"

namespace facet {

/// Called on the estimator's thread; must not block.
class SampleTap {
public:
    virtual ~SampleTap() = default;
    virtual void on_imu(const ImuSample& sample) = 0;
    virtual void on_edge(const TriggerEdge& edge) = 0;
    /// @param frame  stamp of the frame before which the estimator is given it
    virtual void on_range(const RangeSample& /*sample*/, Timestamp /*frame*/) {}
    /// Images that fit together, also of frames that come too late for the estimator.
    virtual void on_pair(const SyncedFrame& pair) = 0;
};

}  // namespace facet
