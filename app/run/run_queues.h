// SPDX-License-Identifier: BSD-2-Clause
// The queues from the sensor threads to the estimator thread.
#pragma once

#include "platform/base/samples.h"
#include "platform/base/spsc_queue.h"
#include "platform/port/camera_source.h"
#include "platform/port/trigger_source.h"

namespace facet {

/// One queue per source, which the source's thread fills and the estimator thread empties. Capacities: no camera has
/// more than eight slots; 256 edges are more than a second at 200 Hz, 4096 inertial samples two seconds at 2 kHz. When
/// full, the sensor thread drops its sample and counts it.
struct RunQueues {
    SpscQueue<CameraFrame, 8> left;  ///< or images of both cameras side by side
    SpscQueue<CameraFrame, 8> right;
    SpscQueue<TriggerEdge, 256> edges;
    SpscQueue<ImuSample, 4096> imu;
};

}  // namespace facet
