// SPDX-License-Identifier: BSD-2-Clause
// What the live grid said of obstacles around the vehicle, against the true scene.
#pragma once

#include <string>
#include <vector>

#include "app/lab/eval/obstacle_truth.h"

namespace facet {

/// A row of rays.csv, in the world of the estimate (app/lab/replay/ray_log.h).
struct RayRow {
    Timestamp stamp;
    Eigen::Vector3d p_W = Eigen::Vector3d::Zero();         ///< the vehicle
    Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  ///< unit
    bool is_in_view = false;                               ///< of the left camera at that time
    bool is_unknown = false;                               ///< unknown space ends the free stretch
    double free_m = 0.0;                                   ///< length of the stretch that the grid calls free
    double obstacle_m = 0.0;                               ///< first occupied cell along it; infinite: none
    double certainty = 0.0;                                ///< of what ends the free stretch, or of the stretch
    double age_s = 0.0;                                    ///< since it was last confirmed
};

/// Reads rays.csv; throws InputError with file and line for a row that is wrong.
std::vector<RayRow> read_rays(const std::string& path);

struct ObstacleEvalOptions {
    double range_m = 5.0;      ///< what a planner looks at
    double tolerance_m = 0.2;  ///< two cells
};

/// Shares of rays, by what the grid says before range_m against the first true surface at distance t (range_m if it is
/// farther):
///   missed   the free stretch reaches beyond t + tolerance
///   false    an occupied cell ends the free stretch before t - tolerance; apart from that, phantom: no true surface is
///            within tolerance of that cell. The others are true obstacles that the ray passes closely
///   unknown  unknown space ends it before t - tolerance
///   right    all others
struct ObstacleShares {
    std::size_t rays = 0;
    std::size_t missed = 0;
    std::size_t false_obstacle = 0;
    std::size_t phantom = 0;  ///< of the false ones
    std::size_t unknown = 0;
    double share(std::size_t count) const {
        return rays > 0 ? static_cast<double>(count) / static_cast<double>(rays) : 0.0;
    }
};

struct ObstacleEvaluation {
    ObstacleShares all;
    ObstacleShares in_view;
    std::size_t hits = 0;         ///< rays that end at an occupied cell within tolerance of the true surface,
    double median_error_m = 0.0;  ///< and their error of distance, median of its magnitude
    double p90_error_m = 0.0;
    double phantom_age_s = 0.0;     ///< of the phantoms, median
    std::size_t without_truth = 0;  ///< rays left out: no true pose at their stamp
};

/// Each ray is placed by the true pose at its stamp: drift of the estimate counts only as far as the grid remembers.
/// Heap. Reentrant.
ObstacleEvaluation evaluate_obstacles(const std::vector<RayRow>& rays, const std::vector<PosePair>& pairs,
                                      const ObstacleTruth& truth, const ObstacleEvalOptions& options);

/// Table for people.
std::string text_report(const ObstacleEvaluation& evaluation);
/// One JSON object as text.
std::string json_report(const ObstacleEvaluation& evaluation);

}  // namespace facet
