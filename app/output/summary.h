// SPDX-License-Identifier: BSD-2-Clause
// The account of a whole run: summary.json.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "app/output/frame_log.h"
#include "app/output/live_account.h"
#include "estimator/api/estimate.h"
#include "estimator/geometry/stereo_rig.h"
#include "estimator/values/residuals.h"
#include "mesh/mesher.h"
#include "mesh/planes/plane_finder.h"
#include "mesh/volume/surface_map.h"

namespace facet {

/// What a run did. Everything but `timing` is the same from run to run.
struct RunSummary {
    struct TimedFrame {
        bool is_keyframe = false;
        FrameTiming timing;
    };

    std::string dataset;
    std::string mode;
    std::map<std::string, std::string> parameters;  ///< that differ from their defaults, by key
    std::string calibration;
    double start_s = 0.0;
    std::vector<std::string> faults;                     ///< put between log and estimator, as the user wrote them
    std::size_t frames_listed = 0;                       ///< in the log, within the window, rows skipped included
    std::size_t rows_skipped = 0;                        ///< of these: rows that cannot be read or go back in time
    std::size_t frames = 0;                              ///< given to the estimator
    std::size_t frames_not_ready = 0;                    ///< of these, without enough inertial data
    std::size_t frames_refused = 0;                      ///< of these, refused by the estimator
    std::size_t reports_without_frame = 0;               ///< rows of health.csv while no frame came
    std::map<std::string, std::size_t> frames_by_state;  ///< TrackingState after each frame
    std::size_t frames_fixed_pattern = 0;                ///< with kReasonFixedPattern
    std::size_t frames_contradicted = 0;                 ///< with kReasonImuContradicted
    std::size_t estimates = 0;                           ///< lines of the trajectory
    std::size_t frames_before_estimate = 0;              ///< given before the first one
    std::size_t keyframes = 0;
    std::size_t imu_samples = 0;
    std::size_t imu_refused = 0;
    std::map<std::string, std::size_t> warnings;  ///< by kind
    double path_m = 0.0;                          ///< length of the estimated path
    bool interrupted = false;
    bool not_finite = false;  ///< an estimate had a NaN or infinity: the run is worthless
    Timestamp first_estimate;
    Estimate last;                    ///< last frame given, whatever its state
    std::vector<TimedFrame> timed;    ///< frames given to the estimator, in order
    VisionResiduals residuals;        ///< of the keyframes that have left the window
    StereoRig rig;                    ///< as given
    CalibrationEstimate corrections;  ///< of the calibration, at the end
    MeshCounters mesh;                ///< what the mesher did
    PlaneCounters planes;             ///< what the plane finder did
    int mesh_vertices = 0;            ///< live at the end
    int mesh_faces = 0;               ///< live at the end
    int mesh_faces_max = 0;           ///< most ever live
    std::size_t run_mesh_faces = 0;   ///< in mesh_horizon.ply
    std::optional<MapCounters> map;   ///< what the map did; none: there was none
    std::size_t map_blocks = 0;       ///< in it at the end,
    std::size_t map_blocks_left = 0;  ///< and given up before
    double wall_s = 0.0;              ///< of the whole run, decoding included
    double greatest_lag_s = 0.0;      ///< of a replay in real time behind its log
    std::optional<LiveAccount> live;  ///< of a live run

    double coverage() const;  ///< estimates per listed frame
};

/// A set of times in figures; median and p99 as OrderStatistics::median() and nearest_rank().
struct TimingStatistics {
    std::size_t count = 0;
    double mean_ms = 0.0;
    double median_ms = 0.0;
    double p99_ms = 0.0;
    double max_ms = 0.0;
};
TimingStatistics timing_statistics(std::vector<double> times_ms);

/// Writes folder/summary.json. Throws InputError if it cannot be written.
void write_summary(const RunSummary& summary, const std::string& folder);

}  // namespace facet
