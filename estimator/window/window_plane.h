// SPDX-License-Identifier: BSD-2-Clause
// A plane as a variable of the window.
#pragma once

#include <boost/container/static_vector.hpp>

#include "estimator/geometry/plane.h"
#include "estimator/values/planes.h"

namespace facet {

/// One plane. Jacobians are first estimates once marginalization has used it, as with keyframes.
struct WindowPlane {
    PlaneId id;
    PlaneKind kind = PlaneKind::kHorizontal;
    Plane plane;
    Plane plane_lin;
    bool is_bound = false;     ///< it is part of the prior
    bool is_aligned = false;   ///< held level or upright by its kind: see plane_gravity.h
    double sigma_m = 0.01;     ///< of a height above it as it counts in the estimate: see RegularityConfig::weigh_m
    int constraints = 0;       ///< landmarks held on it at the last linearization
    double mean_chi2 = 0.0;    ///< of these landmarks' heights if they were free
    int misfit_keyframes = 0;  ///< in a row, with too large a mean_chi2
    int unseen_keyframes = 0;  ///< in a row, without a proposal by the mesh

    const Plane& linearization_point() const { return is_bound ? plane_lin : plane; }
    void bind() {
        if (!is_bound) {
            is_bound = true;
            plane_lin = plane;
        }
    }
};

using WindowPlanes = boost::container::static_vector<WindowPlane, kMaxPlanes>;

}  // namespace facet
