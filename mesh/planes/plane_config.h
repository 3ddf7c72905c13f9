// SPDX-License-Identifier: BSD-2-Clause
// Parameters of the plane finder.
#pragma once

#include "platform/base/status.h"

namespace facet {

/// One line a field: meaning [unit] [range] and why this default.
struct PlaneConfig {
    double face_angle_deg = 4.0;       ///< a face may be turned this far from a plane, beyond 2 sigma [0.5, 30]
    double max_face_angle_deg = 28.0;  ///< but never farther, however uncertain [1, 60]; small faces of noise are
    double max_face_area_m2 = 0.15;    ///< a larger face has no more votes [0.01, 10]; three points are three points
    double min_support_m2 = 0.2;       ///< least votes of a candidate, area after weights [0.01, 100]
    double search_gate_m = 0.15;       ///< landmarks this near to a candidate take part in its first fit [0.02, 1]
    double join_m = 0.08;              ///< a landmark joins a plane within this [0.005, 0.5]
    double join_sigmas = 2.5;          ///< and within this many standard deviations [0.5, 10]
    double stay_m = 0.12;              ///< it leaves beyond this [0.005, 1]
    double stay_sigmas = 3.5;          ///< or beyond so many standard deviations [0.5, 20]
    double max_point_sigma_m = 0.06;   ///< landmarks less certain across the plane are left out [0.005, 1]
    double surface_sigma_m = 0.005;    ///< how flat real surfaces are [0.001, 0.1]
    double max_tilt_deg = 3.0;         ///< of a floor from level, of a wall from upright [0.1, 20]
    int min_landmarks = 14;            ///< of a new plane [4, 256]
    double min_area_m2 = 0.35;         ///< its faces cover at least this [0.01, 100]
    double min_extent_m = 0.12;        ///< standard deviation of its landmarks along its shorter side [0.01, 10]
    double max_chi2 = 1.0;             ///< squared whitened residual per degree of freedom [0.5, 100]; clutter is above
    double max_bend_m = 0.010;         ///< rms of the best quadratic surface against the plane [0.001, 1]
    double max_roughness_m = 0.010;    ///< rms of what neighbouring residuals have in common [0.001, 1]
    double min_coherence = 0.55;       ///< share of the faces with two corners on it whose third is so too [0, 1]
    double same_angle_deg = 5.0;       ///< planes turned farther are never the same [0.1, 30]
    double same_distance_m = 0.06;     ///< nor those farther apart at their landmarks [0.005, 1]
    int confirm_keyframes = 2;         ///< a plane is proposed once found at this many keyframes [1, 20]
    int leave_keyframes = 4;           ///< a plane lost for longer is no longer proposed [1, 100]
    int forget_keyframes = 100;        ///< a plane found again within this many keeps its id [1, 10000]

    /// kInvalidArgument if a field is outside its range, or a landmark would leave before it joins.
    Status validate() const;
};

}  // namespace facet
