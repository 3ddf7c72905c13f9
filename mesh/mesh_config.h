// SPDX-License-Identifier: BSD-2-Clause
// Parameters of the mesher.
#pragma once

#include <algorithm>

#include "platform/base/status.h"

namespace facet {

/// Each field: meaning [range]; why this default.
struct MeshConfig {
    // Landmarks that give new faces.
    double max_depth_m = 8.0;          ///< largest depth in the newest keyframe [0.5, 100]
    double max_depth_sigma_m = 0.32;   ///< largest standard deviation along the ray [0.001, 10]
    double max_chi2 = 4.0;             ///< largest chi-square of a landmark's sightings [0.1, 1000]
    bool use_stereo_points = true;     ///< landmarks that a single keyframe has measured by stereo count, too
    int recent_keyframes = 4;          ///< landmarks unseen for up to this many keyframes count if not hidden [0, 32]
    double recent_distance_px = 12.0;  ///< least distance of such a landmark from other points in the image [0, 200]
    // Shape of a face.
    double min_side_ratio = 0.1;    ///< least shortest over longest side [0, 1]; the paper has 0.2
    double min_elongation = 0.2;    ///< least extent across over extent along the ray [0, 10]; the paper's value
    double max_side_m = 1.2;        ///< longest side [0.05, 100]; the paper has 2
    double max_flat_side_m = 3.0;   ///< longest side with two neighbours in its plane [0.05, 100]: bare walls
    double max_grazing_deg = 80.0;  ///< largest angle between normal and ray [1, 90]
    // Steps of depth.
    double step_sigmas = 3.0;          ///< a difference of depth counts beyond this many standard deviations [0, 20]
    double max_step_slope = 2.0;       ///< largest depth step over lateral distance along a side [0.1, 100]
    double gradient_step_slope = 0.8;  ///< the same for a side that crosses a strong image gradient [0.1, 100]
    double strong_gradient = 60.0;     ///< grey levels over two pixels that count as strong [1, 255]
    double coplanar_m = 0.03;          ///< a steep face is kept if its neighbours lie in its plane this closely [0, 1]
    // Evidence, lonely faces, holes.
    double conflict_margin_m = 0.05;  ///< a face this far in front of a tracked point is contradicted [0, 10]
    int min_contradictions = 2;       ///< this many remove a face if they exceed half its observations [1, 1000]
    double lonely_side_m = 0.7;       ///< a face with a longer side needs neighbours in its plane [0.05, 100]
    int lonely_neighbours = 1;        ///< number of such neighbours [0, 3]
    double hole_planarity_m = 0.04;   ///< a hole is filled if its ring lies in a plane this closely [0, 1]

    /// No face has a longer side, whatever speaks for it (m).
    double longest_side_m() const { return std::max(max_side_m, max_flat_side_m); }

    /// kInvalidArgument if a field is outside its range.
    Status validate() const;
};

}  // namespace facet
