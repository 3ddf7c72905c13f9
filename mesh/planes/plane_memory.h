// SPDX-License-Identifier: BSD-2-Clause
// Planes that left the view long ago, and whether one that is seen now is one of them.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "estimator/values/keyframe_view.h"
#include "estimator/values/planes.h"
#include "mesh/planes/plane_fit.h"
#include "mesh/planes/plane_reach.h"
#include "platform/base/fixed_vector.h"
#include "platform/base/status.h"

namespace facet {

/// Where the vehicle was when it saw a plane, and how far off its heading and place may have been.
struct SightedFrom {
    Eigen::Vector3d p_W = Eigen::Vector3d::Zero();                       ///< (m)
    Eigen::Matrix4d covariance = KeyframeView::HeadingAndPlace::Zero();  ///< KeyframeView::heading_and_place

    /// Covariance of what that does to a plane of this normal at c: its shift along the normal (m), its turn about the
    /// vertical (rad).
    Eigen::Matrix2d effect_at(const Eigen::Vector3d& c_W, const Eigen::Vector3d& normal_W) const;
};

/// A plane as it was when last found.
struct SeenPlane {
    PlaneId id;
    PlaneId proposed;  ///< under which the estimator knows it, if it still does
    PlaneKind kind = PlaneKind::kHorizontal;
    PlaneFit fit;
    PlaneReach reach;  ///< of all of it that was ever seen
    SightedFrom from;
};

/// The last kCapacity planes that have left. A plane seen now is one of them if it differs from it by no more than its
/// own uncertainty, that of the plane when it left, and the drift since explain (chi-square of height and two slopes at
/// its centroid), if their surfaces overlap or nearly so, and if that is true of one of them only: of one that was
/// where the plane is seen now, if others are beside it.
/// The drift's covariance is what the covariance of heading and place, mapped to the plane, has gained since: errors of
/// odometry add up, so that what came in between is independent of what there was. When full, the plane that left first
/// is forgotten. No heap. Thread-bound. 40 KB.
class PlaneMemory {
public:
    static constexpr int kCapacity = 64;  ///< two dozen rooms

    void clear() { planes_.clear(); }
    int size() const { return static_cast<int>(planes_.size()); }
    /// A plane leaves; what was known under its id is replaced.
    void keep(const SeenPlane& plane);
    void forget(PlaneId id);
    /// Takes out the plane that `seen` is. @return kNotFound if it is none of them, or may be several (`out` untouched)
    Status recall(const SeenPlane& seen, SeenPlane& out);
    /// The same, only of one that was where `seen` is: beside it there may be another plane that looks alike.
    Status recall_there(const SeenPlane& seen, SeenPlane& out);

    /// Squared Mahalanobis distance of two planes, of three degrees of freedom; infinite if they face different ways or
    /// their surfaces are apart.
    static double distance(const SeenPlane& then, const SeenPlane& now);

private:
    Status recall(const SeenPlane& seen, bool only_there, SeenPlane& out);

    FixedVector<SeenPlane, kCapacity> planes_;  ///< by departure
};

}  // namespace facet
