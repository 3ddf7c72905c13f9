// SPDX-License-Identifier: BSD-2-Clause
// Planes found in a run against the true planes of the scene.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "app/lab/eval/mesh_accuracy.h"

namespace facet {

/// A row of planes.csv: a plane as it was told at one keyframe, in the world of the estimate.
struct PlaneRow {
    Timestamp stamp;
    std::uint32_t id = 0;
    Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
    double distance = 0.0;  ///< (m)
    double landmarks = 0.0;
    Eigen::Vector3d centroid = Eigen::Vector3d::Zero();  ///< of its landmarks (m)
};

/// Reads planes.csv by the names of its columns. Throws InputError if it cannot be read or a column is missing.
std::vector<PlaneRow> read_planes(const std::string& path);

struct PlaneEvalOptions {
    double max_tilt_deg = kFlatTiltDeg;  ///< true planes farther from level and upright are not asked for
    double seen_depth_m = 5.0;           ///< seen from nearer than this
    double seen_area_m2 = 1.0;           ///< so much of it in one view
    double seen_s = 2.0;                 ///< for so long in all
    double pose_interval_s = 0.2;        ///< between the views of the scene
    double samples_per_m2 = 60.0;        ///< on the true surface
    double match_angle_deg = 5.0;        ///< an estimate is of a true plane if turned no farther,
    double match_offset_m = 0.08;        ///< no farther off at the middle of its landmarks,
    double match_place_m = 1.0;          ///< and no farther from its surface
    double good_angle_deg = 1.0;         ///< what is asked of a match
    double good_offset_m = 0.03;
};

/// How an estimate lies to the true plane it is of.
struct PlaneMatch {
    int truth = -1;  ///< index; -1: of none
    double angle_deg = 0.0;
    double offset_m = 0.0;  ///< at the middle of its landmarks
};

struct TruePlaneResult {
    std::string name;
    double area_m2 = 0.0;  ///< most seen in one view
    double seen_s = 0.0;   ///< with at least PlaneEvalOptions::seen_area_m2 in view
    bool is_wanted = false;
    int keyframes = 0;  ///< at which an estimate of it was told
    int ids = 0;        ///< of how many ids
};

struct FoundPlaneResult {
    std::uint32_t id = 0;
    int keyframes = 0;
    int right = 0;    ///< of these, of some true plane
    PlaneMatch last;  ///< when told last with the most landmarks it ever had, or more than half of them
};

/// Recall counts true planes, precision planes found and also every telling of one.
struct PlaneEvaluation {
    std::vector<TruePlaneResult> truths;  ///< as in the scene: indices of PlaneMatch
    std::vector<FoundPlaneResult> found;
    int wanted = 0;
    int wanted_found = 0;
    int right = 0;  ///< found planes that are of a true one
    std::size_t told = 0;
    std::size_t told_right = 0;
    double median_angle_deg = 0.0;  ///< of all right tellings
    double p90_angle_deg = 0.0;
    double median_offset_m = 0.0;
    double p90_offset_m = 0.0;
    double good_angle = 0.0;   ///< share of right tellings within good_angle_deg
    double good_offset = 0.0;  ///< and within good_offset_m
    double precision() const { return found.empty() ? 0.0 : right / static_cast<double>(found.size()); }
    double recall() const { return wanted > 0 ? static_cast<double>(wanted_found) / wanted : 0.0; }
};

/// Evaluates planes given in the world of the estimate. Heap. Reentrant.
PlaneEvaluation evaluate_planes(const std::vector<PlaneRow>& rows, const SceneTruth& truth, const Se3& T_true_est,
                                const PlaneEvalOptions& options);

}  // namespace facet
