// SPDX-License-Identifier: BSD-2-Clause
// Replays a recorded log through the estimator, synchronously and as fast as it goes.
#pragma once

#include <atomic>
#include <optional>
#include <string>
#include <vector>

#include "app/calibration/calibration.h"
#include "app/config/program_config.h"
#include "app/lab/faults/fault.h"
#include "app/lab/truth/truth_injector.h"
#include "app/output/summary.h"
#include "platform/port/clock.h"
#include "platform/port/odometry_sink.h"

namespace facet {

class FlightViewer;
class LogFiles;
class WorldServer;

/// Time without any sample between two passes of a log.
inline constexpr Duration kSeam{5'000'000'000};
/// A frame that is not ready when inertial samples are this far past its stamp never will be: longer than any time
/// offset that the estimator can find.
inline constexpr Duration kRetry{1'000'000'000};

struct ReplayOptions {
    std::string dataset;        ///< EuRoC/ASL folder
    LogFiles* files = nullptr;  ///< where its files are, if not on the disk; borrowed
    std::string truth_folder;   ///< with ground truth and true scene; empty: the dataset
    std::string out;            ///< folder for the results, created if missing
    ProgramConfig config;
    Calibration calibration;
    double start_s = 0.0;              ///< from the log's first frame
    std::optional<double> duration_s;  ///< all if empty
    int loops = 1;                     ///< how often it is repeated without a seam; it must end as it began
    bool at_imu_rate = false;          ///< the trajectory has a line for every inertial sample, not every frame
    int passes = 1;                    ///< how often the log is played, one pass after the other
    std::vector<Fault> faults;         ///< put between log and estimator; times count from `start_s`
    TruthSelection truth;              ///< what is replaced by the dataset's ground truth
    bool write_rays = false;           ///< also rays.csv, sweeps.csv and grid.png (RayLog, SweepLog, GridPicture)
    bool write_fused = false;          ///< also mesh_fused.ply (MeshFusion)
    bool keep_places = false;          ///< also places.csv and trajectory_map.tum (PlaceLog)
    std::string load_map;              ///< file of an earlier flight's places to be located in; empty: none
    std::string save_map;              ///< file for the places at the end; empty: none
    bool write_calibration = false;    ///< also calibration.csv (CalibrationLog)
    bool show_progress = true;
    OdometrySink* sink = nullptr;        ///< is given every line of the trajectory, and is serviced; or nobody is
    WorldServer* world = nullptr;        ///< is given mesh, planes and grid at each keyframe; or nobody is
    std::vector<FlightViewer*> viewers;  ///< are shown every frame
    SurfaceSink* surface = nullptr;      ///< is given the map's surface as it changes, beside mesh.ply; or nobody is
    bool in_real_time = false;           ///< samples come no faster than they were recorded
};

/// Runs the log on the calling thread, without other threads: each inertial sample up to the first at or after a frame,
/// then the frame; a frame for which the estimator wants later samples is offered again after each of them, for kRetry
/// at most; at keyframes also the mesher and the plane finder. Writes trajectory.tum, trajectory.csv,
/// timing.csv, health.csv, mesh.csv, planes.csv, mesh.ply, mesh_live.ply, planes.json, residuals.csv, summary.json and
/// warnings.txt into `out`. Equal inputs give equal bytes, except for times, which do not include reading and decoding.
/// @param stop  set from elsewhere (a signal) to end after the current frame; the files are complete up to there
/// Timing and health carry the frame's stamp, the trajectory that of the estimate, from which the estimator may have
/// removed an offset. An injected offset is in the former: an estimator that does not find it pays for it in the
/// comparison with ground truth. Injected jumps of the clock are removed from all files.
/// Between two passes the stamps go on, but samples are missing for kSeam: the estimator is lost and restarts, as
/// after any long gap. With several passes timing.csv has all frames, but the summary and mesh.ply keep only the
/// newest, so that memory does not grow.
/// Images or calibrations that are exchanged, and one camera recorded twice, are warned of at the start (StartCheck).
/// Throws InputError if the dataset or the rig cannot be used, or a file cannot be written.
RunSummary run_replay(const ReplayOptions& options, const std::atomic<bool>& stop);

}  // namespace facet
