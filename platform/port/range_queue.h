// SPDX-License-Identifier: BSD-2-Clause
// Readings of a range finder, from the thread that hears them to the estimator's.
#pragma once

#include "platform/base/range_sample.h"
#include "platform/base/spsc_queue.h"

namespace facet {

/// A second of readings at 256 Hz; when full, the newest is dropped.
using RangeQueue = SpscQueue<RangeSample, 256>;

}  // namespace facet
