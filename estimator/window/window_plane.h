// SPDX-License-Identifier: BSD-2-Clause
// A plane as a variable of the window, and the relation between two of them.
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

/// Two planes, or a plane and the vertical, that are parallel or orthogonal.
struct PlanePair {
    static constexpr int kVertical = -1;  ///< in place of plane b: the direction of gravity

    int a = 0;  ///< index of a plane of the window
    int b = kVertical;
    bool is_parallel = true;  ///< else orthogonal

    bool operator==(const PlanePair&) const = default;
};

/// Each pair of planes, and each plane with the vertical.
inline constexpr int kMaxPlanePairs = kMaxPlanes * (kMaxPlanes - 1) / 2 + kMaxPlanes;

using WindowPlanes = boost::container::static_vector<WindowPlane, kMaxPlanes>;
using PlanePairs = boost::container::static_vector<PlanePair, kMaxPlanePairs>;

}  // namespace facet
