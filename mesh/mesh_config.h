// SPDX-License-Identifier: BSD-2-Clause
// Parameters of the mesher.
#pragma once

#include <algorithm>

#include "estimator/values/capacity.h"
#include "platform/base/parameter_field.h"
#include "platform/base/status.h"

namespace facet {

/// Units, ranges and meanings: kMeshFields below.
struct MeshConfig {
    /// The camera has flown through what is nearer to its path than this: there is no surface (m).
    static constexpr double kBodyRadius_m = 0.05;
    double max_depth_m = 8.0;
    double max_depth_sigma_m = 0.32;
    double max_chi2 = 4.0;
    bool use_stereo_points = true;
    int recent_keyframes = 4;
    double min_side_ratio = 0.1;
    double min_elongation = 0.2;
    double max_side_m = 1.2;
    double max_flat_side_m = 3.0;
    double max_grazing_deg = 80.0;
    double max_step_slope = 2.0;
    double gradient_step_slope = 0.8;
    double coplanar_m = 0.03;
    int lonely_neighbours = 1;
    double conflict_margin_m = 0.05;
    int min_contradictions = 2;
    double max_unseen_s = 5.0;

    /// No face has a longer side, whatever speaks for it (m).
    double longest_side_m() const { return std::max(max_side_m, max_flat_side_m); }

    /// kInvalidArgument if a field is outside its range.
    Status validate() const;
};

inline constexpr auto kMeshFields = std::to_array<ParameterField<MeshConfig>>({
    {FACET_FIELD(MeshConfig, max_depth_m), "m", 0.5, 100,
     "Landmarks farther than this from the newest keyframe give no new faces."},
    {FACET_FIELD(MeshConfig, max_depth_sigma_m), "m", 1e-3, 10,
     "Landmarks whose standard deviation along the ray exceeds this give no new faces."},
    {FACET_FIELD(MeshConfig, max_chi2), "-", 0.1, 1000,
     "Landmarks whose squared residuals per degree of freedom exceed this give no new faces: their observations "
     "contradict each other."},
    {FACET_FIELD(MeshConfig, use_stereo_points), "-", 0, 1,
     "Also use landmarks that the stereo match of a single keyframe gives."},
    {FACET_FIELD(MeshConfig, recent_keyframes), "-", 0, kMaxKeyframes,
     "Landmarks out of sight for up to this many keyframes also give faces, unless something hides them."},
    {FACET_FIELD(MeshConfig, min_side_ratio), "-", 0, 1,
     "Least ratio of a face's shortest side to its longest; the paper has 0.2."},
    {FACET_FIELD(MeshConfig, min_elongation), "-", 0, 10,
     "Least ratio of a face's extent across the ray to its extent along it; the default is the paper's."},
    {FACET_FIELD(MeshConfig, max_side_m), "m", 0.05, 100,
     "Longest side of a face without two neighbours in its plane; the paper has 2 m for all faces."},
    {FACET_FIELD(MeshConfig, max_flat_side_m), "m", 0.05, 100,
     "Longest side of a face with two neighbours in its plane, as on bare walls."},
    {FACET_FIELD(MeshConfig, max_grazing_deg), "deg", 1, 90,
     "Largest angle between a face's normal and the ray to it."},
    {FACET_FIELD(MeshConfig, max_step_slope), "-", 0.1, 100,
     "Largest ratio of depth step to lateral distance along a side of a face."},
    {FACET_FIELD(MeshConfig, gradient_step_slope), "-", 0.1, 100,
     "Largest ratio of depth step to lateral distance along a side that crosses a strong image gradient."},
    {FACET_FIELD(MeshConfig, coplanar_m), "m", 0, 1,
     "A neighbour is in the plane of a face if its far corner is within this distance of it; faces that are steep or "
     "large need such neighbours."},
    {FACET_FIELD(MeshConfig, lonely_neighbours), "-", 0, 3,
     "Number of neighbours in its plane that a face with a side above lonely_side_m needs."},
    {FACET_FIELD(MeshConfig, conflict_margin_m), "m", 0, 10,
     "A face contradicts a tracked landmark seen through it if it is in front of it by more than this, "
     "uncertainties added."},
    {FACET_FIELD(MeshConfig, min_contradictions), "-", 1, 1000,
     "A face is removed when at least this many keyframes contradict it and they are more than half as many as those "
     "that confirm it."},
    {FACET_FIELD(MeshConfig, max_unseen_s), "s", 0.1, 3600,
     "A face leaves the mesh after this time in view without being confirmed or covered by newer faces."},
});

}  // namespace facet
