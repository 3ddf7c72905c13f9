// SPDX-License-Identifier: BSD-2-Clause
// On which plane of the run a piece of surface lies.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <span>

#include "app/output/plane_names.h"
#include "mesh/mesher.h"

namespace facet {

/// Planes as the faces of the horizon's mesh show them: their mean, weighted by area, and where they reach. Heap.
/// Reentrant once made.
class SurfacePlanes {
public:
    SurfacePlanes() = default;
    /// @param faces  of the whole run
    SurfacePlanes(std::span<const DepartedFace> faces, const PlaneNames& names);

    /// The plane of which a face is within 20 cm, if the place is within 3 cm of it and turned from it by no more than
    /// 25 degrees; the nearest of several; -1: none.
    std::int32_t plane_of(const Eigen::Vector3f& p_W, const Eigen::Vector3f& normal_W) const;

private:
    struct Plane {
        Eigen::Vector3f normal_W = Eigen::Vector3f::Zero();
        float distance_m = 0.0F;
        float area_m2 = 0.0F;
        std::set<std::array<int, 3>> cells;  ///< that faces pass
    };
    std::map<std::int32_t, Plane> planes_;  ///< by id
};

}  // namespace facet
