// SPDX-License-Identifier: BSD-2-Clause
// A plane as a variable of the window, and how two of them lie to each other.
#pragma once

#include <boost/container/static_vector.hpp>

#include "estimator/geometry/plane.h"
#include "estimator/values/planes.h"

namespace facet {

/// One plane. First-estimate Jacobians from when marginalization has used it, as with keyframes.
struct WindowPlane {
    PlaneId id;
    PlaneKind kind = PlaneKind::kHorizontal;
    Plane plane;
    Plane plane_lin;
    bool is_bound = false;     ///< the prior knows it
    int constraints = 0;       ///< landmarks that it held at the last linearization
    double mean_chi2 = 0.0;    ///< of these landmarks' heights, were they free
    int misfit_keyframes = 0;  ///< in a row, at which that was too much
    int unseen_keyframes = 0;  ///< in a row, at which the mesh did not propose it

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
