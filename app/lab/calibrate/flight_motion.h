// SPDX-License-Identifier: BSD-2-Clause
// Whether a flight moves enough for a calibration to be seen in it.
#pragma once

#include <string>

#include "app/lab/calibrate/recorded_flight.h"

namespace facet {

/// How much a flight turns and moves.
struct FlightMotion {
    double duration_s = 0.0;
    double path_m = 0.0;
    /// Standard deviations of the attitude about the axes in which it varies most, second most and least (rad): from
    /// the rotation vectors against the mean attitude.
    Eigen::Vector3d turned_rad = Eigen::Vector3d::Zero();
    double accelerated_m_per_s2 = 0.0;  ///< rms of the velocity's change per time between keyframes
};

/// Reentrant. Heap.
FlightMotion measure_motion(const RecordedFlight& flight);

/// One plain sentence if the motion cannot show a calibration: standing, straight flight, turns about one axis only.
/// Empty if it may.
std::string motion_complaint(const FlightMotion& motion);

}  // namespace facet
