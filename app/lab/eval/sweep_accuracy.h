// SPDX-License-Identifier: BSD-2-Clause
// The distances all around that a flight controller was sent, against the true scene.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "app/lab/eval/obstacle_truth.h"

namespace facet {

inline constexpr std::size_t kSweepRowSectors = 72;

/// A row of sweeps.csv, in the world of the estimate (app/lab/replay/sweep_log.h).
struct SweepRow {
    Timestamp stamp;
    Eigen::Vector3d p_W = Eigen::Vector3d::Zero();   ///< the vehicle
    double ahead_rad = 0.0;                          ///< azimuth of the middle of sector 0, counterclockwise
    double below_m = 0.0;                            ///< what is so far below the vehicle
    double above_m = 0.0;                            ///< to so far above it counts
    std::array<double, kSweepRowSectors> range_m{};  ///< clockwise; infinite: free, NaN: unknown
};

/// Reads sweeps.csv; throws InputError with file and line for a row that is wrong.
std::vector<SweepRow> read_sweeps(const std::string& path);

struct SweepEvalOptions {
    double range_m = 5.0;      ///< what a planner looks at
    double tolerance_m = 0.2;  ///< two cells
    double margin_m = 0.1;     ///< a cell: surfaces so far beyond sector and band may share one with them
};

/// Sectors by what is reported, r, against the nearest true surface t in sector and band, whether it can be seen or
/// not; both range_m if farther.
struct SweepEvaluation {
    std::size_t sectors = 0;
    std::size_t missed = 0;          ///< r > t + tolerance, or free although t is within range
    std::size_t false_obstacle = 0;  ///< r < t - tolerance, t in sector and band widened by the margin
    std::size_t unknown = 0;
    std::size_t hits = 0;         ///< r and t within range,
    double median_error_m = 0.0;  ///< and their difference, median of its magnitude
    double p90_error_m = 0.0;
    std::size_t without_truth = 0;  ///< sweeps left out: no true pose at their stamp
    double share(std::size_t count) const {
        return sectors > 0 ? static_cast<double>(count) / static_cast<double>(sectors) : 0.0;
    }
};

/// Each sweep is placed by the true pose at its stamp. Surfaces are known by their samples: distances are up to a few
/// centimetres too great. Heap. Reentrant.
SweepEvaluation evaluate_sweeps(const std::vector<SweepRow>& sweeps, const std::vector<PosePair>& pairs,
                                const ObstacleTruth& truth, const SweepEvalOptions& options);

/// Table for people.
std::string text_report(const SweepEvaluation& evaluation);
/// One JSON object as text.
std::string json_report(const SweepEvaluation& evaluation);

}  // namespace facet
