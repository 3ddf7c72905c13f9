// SPDX-License-Identifier: BSD-2-Clause
// What the estimator remembers from frame to frame beside samples, tracks and window: plain values.
#pragma once

#include <optional>

#include "estimator/api/belief.h"
#include "estimator/api/estimate.h"
#include "estimator/flight/clock_watch.h"
#include "estimator/flight/emitter_watch.h"
#include "estimator/flight/gauge_tracker.h"
#include "estimator/flight/inertial_fault.h"
#include "estimator/flight/phase.h"
#include "estimator/flight/reset_counter.h"
#include "estimator/flight/rest_detector.h"
#include "estimator/flight/start_progress.h"
#include "estimator/flight/stereo_evidence.h"
#include "estimator/imu/imu_buffer.h"
#include "estimator/values/camera_corrections.h"
#include "estimator/window/window.h"

namespace facet {

/// What the newest frame's comparison with the map has shown.
struct MapFit {
    int landmarks = 0;  ///< that it was compared with
    double chi2 = 0.0;
};

/// The newest keyframe's turn in the window.
struct KeyframeOutcome {
    WindowSummary summary;
    bool is_new = false;        ///< no estimate has reported it yet
    bool view_is_open = false;  ///< its view is still to be filled
};

/// Each part judges one thing from the evidence that FlightEstimator gives it; only that knows them all. Reset by
/// assignment.
struct FlightState {
    Phase phase = Phase::kEmpty;
    Belief newest;        ///< at the newest keyframe
    Belief unsuspecting;  ///< at the last keyframe before the present suspicion, while there is one
    Belief now;           ///< at the newest frame
    ImuSpan span;         ///< samples between them
    /// The newest estimate that was to be used, of this program or of an earlier one.
    std::optional<Belief> trusted;
    StartProgress start;
    RestDetector rest;
    InertialFault fault;
    StereoEvidence stereo;
    GaugeTracker gauge;
    ClockWatch clocks;
    EmitterWatch emitter;
    FrameTimes frames;
    ResetCounter resets;
    MapFit fit;
    KeyframeOutcome keyframe;
    CameraCorrections corrections;  ///< that the front-end works with
    RigCalibration::Tangent calibration_sigma = RigCalibration::Tangent::Zero();
    std::optional<Estimate> carried;  ///< the newest one without a frame that nobody has asked for yet
    bool restart_requested = false;   ///< of the window, at the next frame that allows it: by the user, for want of
                                      ///< landmark ids, or after time that is on no clock
    bool keeps_place = false;         ///< the next window begins where the last one was, as uncertain as is reported
    bool is_late = false;             ///< a frame took too long: less work up to the next keyframe
};

}  // namespace facet
