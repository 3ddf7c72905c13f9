// SPDX-License-Identifier: BSD-2-Clause
// The simulator: scene, flight, images, inertial samples and truth into one dataset folder.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "app/lab/faults/rotor_vibration.h"
#include "app/lab/sim/default_rig.h"
#include "app/lab/sim/flight.h"
#include "platform/base/status.h"

namespace facet::sim {

/// One line a field: meaning [unit] [range] and why this default.
struct SimOptions {
    std::string scene = "room";  ///< one of scene_names()
    std::string out;             ///< folder to write
    std::uint64_t seed = 1;      ///< of flight, noise and what a building is like
    double duration_s = 30.0;    ///< from first to last image [0.1, 3600]
    double rate_hz = 20.0;       ///< of the cameras [1, 200]
    double imu_rate_hz = 200.0;  ///< of the inertial samples [100, 2000]
    int samples = 3;             ///< rays per pixel [1, 32]; 5 leave no visible sparkle, 3 none that tracking minds
    int threads = 2;             ///< [1, 64]; the output does not depend on it
    bool noise = true;           ///< false: no image noise, no inertial noise and no bias
    bool force = false;          ///< replace mav0/ and truth/ in a folder that is not empty
    int texture_size = 1024;     ///< texels [16, 4096], a power of two
    double stand_s = 2.5;        ///< motionless at the start [0, 600]
    FlightKind flight = FlightKind::kTour;
    LensKind camera = LensKind::kPinhole;
    VibrationKind vibration = VibrationKind::kNone;  ///< of rotors, on the inertial samples; kHover: of flight at least
    bool closed = false;                             ///< the flight ends as it began; exact inertial samples
    bool mover = false;                              ///< a box crosses the view now and then
    double time_offset_s = 0.0;        ///< added to the stamps of the images, not to their time [-0.05, 0.05]
    double extrinsic_error_deg = 0.0;  ///< by which the written T_B_C are turned, both as one [0, 30]
    double gravity_m_per_s2 = 9.81;    ///< [1, 30]; the flight is the same, the IMU feels it
    double exposure_s = 0.006;         ///< of an image, in which its pixels' samples are spread (0, 1 / rate]
    double contrast = 1.0;             ///< of all surfaces, in units of what the scene has [0, 1]
    double range_sigma_m = -1.0;       ///< of a range finder that looks down [0, 1]; negative: there is none
    double calibration_error = 0.0;    ///< K of the written cameras, in sigma of a good calibration [0, 100]
};

/// What was made.
struct SimSummary {
    int frames = 0;
    int planes = 0;
    FlightReport flight;
    double prepare_s = 0.0;     ///< scene, light, flight (wall clock)
    double render_s = 0.0;      ///< images (wall clock)
    double ms_per_image = 0.0;  ///< CPU time, rendering and writing
};

/// Called with zeros when preparation begins, then after each image, by one thread at a time: images done and in all.
using SimProgress = std::function<void(int done, int total)>;

/// Runs the simulator. Same options, same bytes, except options.threads.
/// @param error  one line for the user on anything but kOk
/// @return kInvalidArgument: an option is out of range or the folder is not empty; kIo: a file cannot be written;
///         kDegenerate: no flight with enough clearance was found.
Status simulate(const SimOptions& options, const SimProgress& progress, SimSummary& summary, std::string& error);

}  // namespace facet::sim
