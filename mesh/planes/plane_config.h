// SPDX-License-Identifier: BSD-2-Clause
// Parameters of the plane finder.
#pragma once

#include "platform/base/status.h"

namespace facet {

/// Each field: meaning [range]; why this default.
struct PlaneConfig {
    // Votes of faces.
    double face_angle_deg = 4.0;       ///< largest angle of a face to its plane, beyond 2 sigma [0.5, 30]
    double max_face_angle_deg = 28.0;  ///< the same with any uncertainty: small faces are uncertain [1, 60]
    double max_face_area_m2 = 0.15;    ///< larger faces vote with this area: three points say no more [0.01, 10]
    double min_support_m2 = 0.2;       ///< least votes of a candidate: area after weights [0.01, 100]
    // Landmarks on a plane.
    double search_gate_m = 0.15;      ///< landmarks this near to a candidate take part in its first fit [0.02, 1]
    double join_m = 0.08;             ///< largest distance of a landmark that joins a plane [0.005, 0.5]
    double join_sigmas = 2.5;         ///< the same in standard deviations; both hold [0.5, 10]
    double stay_m = 0.12;             ///< largest distance of a landmark that stays on a plane [0.005, 1]
    double stay_sigmas = 3.5;         ///< the same in standard deviations; both hold [0.5, 20]
    double max_point_sigma_m = 0.06;  ///< landmarks less certain across the plane are left out [0.005, 1]
    double surface_sigma_m = 0.005;   ///< unevenness of real surfaces [0.001, 0.1]
    // What a set of landmarks has to satisfy to be a plane.
    double max_tilt_deg = 3.0;       ///< of a floor from level, of a wall from upright [0.1, 20]
    int min_landmarks = 14;          ///< of a new plane [4, 256]
    double min_area_m2 = 0.35;       ///< of its faces [0.01, 100]
    double min_extent_m = 0.12;      ///< standard deviation of its landmarks along its shorter side [0.01, 10]
    double max_chi2 = 1.0;           ///< squared whitened residual per degree of freedom [0.5, 100]; clutter has more
    double max_bend_m = 0.010;       ///< rms of the best quadratic surface against the plane [0.001, 1]
    double max_roughness_m = 0.010;  ///< rms of the common part of neighbouring residuals [0.001, 1]
    double min_coherence = 0.55;     ///< share of the faces with two corners on it whose third is on it, too [0, 1]
    // Identity.
    double same_angle_deg = 5.0;    ///< largest angle between planes that may be the same [0.1, 30]
    double same_distance_m = 0.06;  ///< largest distance between them at their landmarks [0.005, 1]
    int confirm_keyframes = 2;      ///< a plane is proposed once found at this many keyframes [1, 20]
    int leave_keyframes = 4;        ///< a plane lost for longer is no longer proposed [1, 100]
    int forget_keyframes = 100;     ///< a plane found again within this many keeps its id [1, 10000]

    /// kInvalidArgument if a field is outside its range, or a landmark would leave before it joins.
    Status validate() const;
};

}  // namespace facet
