// SPDX-License-Identifier: BSD-2-Clause
// Refines the calibration of a log's cameras from the flight in it.
#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "app/lab/calibrate/flight_motion.h"
#include "app/lab/calibrate/recorded_flight.h"
#include "app/lab/calibrate/rig_parameters.h"

namespace facet {

struct CalibrateOptions {
    RecordingOptions recording;
    std::string out;           ///< folder for the results, created if there are any
    double prior_scale = 1.0;  ///< of prior_sigmas()
};

/// What came of it.
struct CalibrateReport {
    std::string refusal;  ///< one sentence if the flight does not show the calibration: nothing was written
    FlightMotion motion;
    int keyframes = 0;
    int points = 0;
    double pixel_sigma_px = 0.0;
    std::vector<RigParameter> parameters;
};

/// Flies the log (record_flight), fits the flight and the calibration as one (solve_batch) and writes into `out` the
/// files of calibration_files.h and residuals_cam0_before.png, residuals_cam0_after.png and those of cam1.
/// Nothing is written if the motion does not suffice: see motion_complaint() and unseen_complaint().
/// Throws InputError if the log cannot be used, or a file cannot be written. Heap. Thread-bound.
CalibrateReport calibrate(const CalibrateOptions& options, const std::atomic<bool>& stop);

/// One sentence if a principal point, or the cameras' rotation on the body, stays unseen: what the flight then says of
/// the other parameters is not to be relied on. Empty otherwise.
std::string unseen_complaint(const std::vector<RigParameter>& parameters);

}  // namespace facet
