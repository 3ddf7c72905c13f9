// SPDX-License-Identifier: BSD-2-Clause
// What mesh and estimator exchange about planes: proposals one way, estimates the other.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "estimator/values/capacity.h"
#include "platform/base/fixed_vector.h"
#include "platform/base/typed_id.h"

namespace facet {

/// Orientation of a plane relative to gravity.
enum class PlaneKind : std::uint8_t {
    kHorizontal,  ///< floor, table, ceiling
    kVertical,    ///< wall
    kSlanted,     ///< ramp, pitched ceiling: gravity says nothing of its direction
};

constexpr const char* to_string(PlaneKind kind) {
    switch (kind) {
        case PlaneKind::kHorizontal: return "horizontal";
        case PlaneKind::kVertical: return "vertical";
        case PlaneKind::kSlanted: return "slanted";
    }
    return "unknown";
}

/// Whether two planes of these kinds may be one and the same: near the limit of what counts as level or upright a plane
/// is of either kind, from one sighting to the next.
constexpr bool may_be_one(PlaneKind a, PlaneKind b) {
    return a == b || a == PlaneKind::kSlanted || b == PlaneKind::kSlanted;
}

/// A plane n . p = d that the mesh has found, and the landmarks on it, at one keyframe. The plane keeps its id as long
/// as the mesh knows it. A plane merged into another is left out; its landmarks belong to the other from then on.
struct PlaneProposal {
    PlaneId id;
    PlaneKind kind = PlaneKind::kHorizontal;
    Eigen::Vector3d normal_W = Eigen::Vector3d::UnitZ();    ///< unit, to the side the plane was seen from
    double distance_m = 0.0;                                ///< (m)
    FixedVector<LandmarkId, kMaxPlaneLandmarks> landmarks;  ///< by increasing id; each on one plane only
};

/// By increasing id. About 35 KB.
using PlaneProposals = FixedVector<PlaneProposal, kMaxPlanes>;

/// A plane as the newest optimization leaves it.
struct PlaneEstimate {
    PlaneId id;
    PlaneKind kind = PlaneKind::kHorizontal;
    Eigen::Vector3d normal_W = Eigen::Vector3d::UnitZ();  ///< unit, same side as the proposal's
    double distance_m = 0.0;                              ///< (m)
    int constraints = 0;                                  ///< landmarks of the window that are held on the plane
};

/// By increasing id.
using PlaneEstimates = FixedVector<PlaneEstimate, kMaxPlanes>;

}  // namespace facet
