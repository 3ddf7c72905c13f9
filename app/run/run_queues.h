// SPDX-License-Identifier: BSD-2-Clause
// The ways from the sensor threads to the estimator thread.
#pragma once

#include "platform/base/samples.h"
#include "platform/base/spsc_queue.h"
#include "platform/port/camera_source.h"
#include "platform/port/trigger_source.h"

namespace facet {

/// One queue a source; each has one producer, the estimator thread is the consumer of all. Capacities: a camera has no more
/// slots than eight; edges of more than a second at 200 Hz; inertial samples of two seconds at 2 kHz. When full, the sensor
/// thread drops its sample, which the queue counts.
struct RunQueues {
    SpscQueue<CameraFrame, 8> left;  ///< or the images of both, side by side
    SpscQueue<CameraFrame, 8> right;
    SpscQueue<TriggerEdge, 256> edges;
    SpscQueue<ImuSample, 4096> imu;
};

}  // namespace facet
