// SPDX-License-Identifier: BSD-2-Clause
// Planes found in a run against the true planes of the scene.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "app/lab/eval/mesh_accuracy.h"
#include "app/lab/eval/plane_rows.h"
#include "app/lab/eval/strict_planes.h"

namespace facet {

struct PlaneEvalOptions {
    // A true plane has to be found (is a target) if it is level or upright, and was seen well for long enough.
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
    StrictOptions strict;
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

/// Evaluates planes given in the world of the estimate. @param surfaces  what is known of where they are. Heap.
/// Reentrant.
PlaneEvaluation evaluate_planes(const std::vector<PlaneRow>& rows, const std::optional<PlaneSurfaces>& surfaces,
                                const SceneTruth& truth, const Se3& T_true_est, const PlaneEvalOptions& options);

}  // namespace facet
