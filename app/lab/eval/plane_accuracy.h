// SPDX-License-Identifier: BSD-2-Clause
// Planes found in a run against the true planes of the scene.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "app/lab/eval/mesh_accuracy.h"

namespace facet {

/// A row of planes.csv: a plane as reported at one keyframe, in the world of the estimate.
struct PlaneRow {
    Timestamp stamp;
    std::uint32_t id = 0;
    Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
    double distance = 0.0;  ///< (m)
    double landmarks = 0.0;
    double area_m2 = 0.0;                                ///< of its faces
    Eigen::Vector3d centroid = Eigen::Vector3d::Zero();  ///< of its landmarks (m)
};

/// Reads planes.csv by the names of its columns. Throws InputError if it cannot be read or a column is missing.
std::vector<PlaneRow> read_planes(const std::string& path);

struct PlaneEvalOptions {
    // A true plane has to be found (is "wanted") if it is level or upright, and was seen well for long enough.
    double max_tilt_deg = kFlatTiltDeg;  ///< largest tilt from level or upright
    double seen_depth_m = 5.0;           ///< a view counts surface nearer than this
    double seen_area_m2 = 1.0;           ///< least area in one view
    double seen_s = 2.0;                 ///< least total time with that much in view
    double pose_interval_s = 0.2;        ///< between the views of the scene
    double samples_per_m2 = 60.0;        ///< on the true surface
    // An estimate matches a true plane if it is within all three limits.
    double match_angle_deg = 5.0;  ///< between the normals
    double match_offset_m = 0.08;  ///< of the centroid of its landmarks from the true plane
    double match_place_m = 1.0;    ///< of the centroid from the plane's true surface
    // A match is good in angle or offset within these.
    double good_angle_deg = 1.0;
    double good_offset_m = 0.03;
    // Strict matching: also of this size, and with true surface under so much of a disc of the estimate's area.
    double strict_angle_deg = 2.0;
    double strict_offset_m = 0.03;
    double strict_overlap = 0.5;
    double strict_seen_m2 = 0.5;  ///< a true plane of any tilt is wanted from so much seen surface on
};

/// The true plane that an estimate matches, and how far it is off.
struct PlaneMatch {
    int truth = -1;  ///< index; -1: it matches none
    double angle_deg = 0.0;
    double offset_m = 0.0;  ///< at the centroid of its landmarks
};

struct TruePlaneResult {
    std::string name;
    double area_m2 = 0.0;  ///< most seen in one view
    double seen_s = 0.0;   ///< with at least PlaneEvalOptions::seen_area_m2 in view
    double seen_m2 = 0.0;  ///< in all views together
    bool is_wanted = false;
    int keyframes = 0;  ///< at which an estimate that matches it was reported
    int ids = 0;        ///< different ids among these estimates
};

struct FoundPlaneResult {
    std::uint32_t id = 0;
    int keyframes = 0;
    int right = 0;    ///< of these, with a match
    PlaneMatch last;  ///< when last reported with more than half of the most landmarks it had had until then
};

/// Planes judged strictly: a found plane is of a true one if it matches it strictly at more than half of its keyframes,
/// and all but one of several that are of the same true plane are wrong.
struct StrictPlanes {
    int found = 0;
    int right = 0;
    int wanted = 0;
    int wanted_found = 0;
    double wanted_m2 = 0.0;  ///< seen area of the true planes wanted,
    double found_m2 = 0.0;   ///< and of those found
    double precision() const { return found > 0 ? static_cast<double>(right) / found : 0.0; }
    double recall() const { return wanted > 0 ? static_cast<double>(wanted_found) / wanted : 0.0; }
    double area_recall() const { return wanted_m2 > 0.0 ? found_m2 / wanted_m2 : 0.0; }
};

/// Recall counts true planes, precision the planes found; `told` counts reports, one for every keyframe and plane.
struct PlaneEvaluation {
    std::vector<TruePlaneResult> truths;  ///< as in the scene: indices of PlaneMatch
    std::vector<FoundPlaneResult> found;
    int wanted = 0;
    int wanted_found = 0;
    int right = 0;  ///< found planes with a match at more than half of their keyframes
    std::size_t told = 0;
    std::size_t told_right = 0;
    double median_angle_deg = 0.0;  ///< of all reports with a match; quantiles as OrderStatistics::quantile()
    double p90_angle_deg = 0.0;
    double median_offset_m = 0.0;
    double p90_offset_m = 0.0;
    double good_angle = 0.0;   ///< share of the reports with a match that are within good_angle_deg
    double good_offset = 0.0;  ///< likewise within good_offset_m
    StrictPlanes strict;
    double precision() const { return found.empty() ? 0.0 : right / static_cast<double>(found.size()); }
    double recall() const { return wanted > 0 ? static_cast<double>(wanted_found) / wanted : 0.0; }
};

/// Evaluates planes given in the world of the estimate. Heap. Reentrant.
PlaneEvaluation evaluate_planes(const std::vector<PlaneRow>& rows, const SceneTruth& truth, const Se3& T_true_est,
                                const PlaneEvalOptions& options);

}  // namespace facet
