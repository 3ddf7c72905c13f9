// SPDX-License-Identifier: BSD-2-Clause
// Parameters of the mesher.
#pragma once

#include <algorithm>

#include "platform/base/status.h"

namespace facet {

/// One line a field: meaning [unit] [range] and why this default.
struct MeshConfig {
    double max_depth_m = 8.0;         ///< landmarks farther from the newest keyframe give no new face [0.5, 100]
    double max_depth_sigma_m = 0.32;  ///< nor those less certain along the ray [0.001, 10]
    double max_chi2 = 4.0;            ///< nor those whose sightings contradict each other more [0.1, 1000]
    bool use_stereo_points = true;    ///< also landmarks that only one keyframe's stereo match gives
    int recent_keyframes =
        4;  ///< landmarks unseen for up to this many keyframes, if not hidden, also give faces [0, 32]
    double recent_distance_px = 12.0;  ///< but not nearer to other points in the image [0, 200]
    double min_side_ratio = 0.1;       ///< least shortest over longest side of a face [0, 1]; the paper has 0.2
    double min_elongation = 0.2;       ///< least extent across over extent along the ray [0, 10]; the paper's value
    double max_side_m = 1.2;           ///< longest side of a face [0.05, 100]; the paper has 2
    double max_flat_side_m = 3.0;   ///< longest side of a face with two neighbours in its plane [0.05, 100]: bare walls
    double max_grazing_deg = 80.0;  ///< largest angle between a face's normal and the ray [1, 90]
    double step_sigmas = 3.0;       ///< a difference of depth counts beyond this many standard deviations [0, 20]
    double max_step_slope = 2.0;    ///< largest depth step over lateral distance along a side [0.1, 100]
    double gradient_step_slope = 0.8;  ///< the same if the side crosses a strong image gradient [0.1, 100]
    double strong_gradient = 60.0;     ///< grey levels over two pixels that count as strong [1, 255]
    double coplanar_m = 0.03;          ///< a steep face is kept if its neighbours lie in its plane this closely [0, 1]
    double conflict_margin_m = 0.05;   ///< a face this far in front of a tracked point is contradicted [0, 10]
    int min_contradictions = 2;        ///< a face leaves when contradicted this often, and more than observed [1, 1000]
    double lonely_side_m = 0.7;        ///< a face with a longer side needs neighbours in its plane [0.05, 100]
    int lonely_neighbours = 1;         ///< so many of them [0, 3]
    double hole_planarity_m = 0.04;    ///< a hole is filled if its ring lies in a plane this closely [0, 1]

    /// No face has a longer side, whatever speaks for it (m).
    double longest_side_m() const { return std::max(max_side_m, max_flat_side_m); }

    /// kInvalidArgument if a field is outside its range.
    Status validate() const;
};

}  // namespace facet
