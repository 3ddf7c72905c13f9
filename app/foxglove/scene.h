// SPDX-License-Identifier: BSD-2-Clause
// Mesh and planes as scenes of Foxglove: foxglove.SceneUpdate.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "estimator/values/planes.h"
#include "platform/base/timestamp.h"

namespace facet {

/// A triangle of the mesh (m, in W) and its plane, -1 for none.
struct SceneFace {
    std::array<Eigen::Vector3f, 3> p_W;
    std::int32_t plane = -1;
};

/// A plane as the rectangle whose points have the spread of those on the plane.
struct ScenePlane {
    std::int32_t id = -1;
    PlaneKind kind = PlaneKind::kHorizontal;
    Eigen::Vector3f centre_W = Eigen::Vector3f::Zero();  ///< (m)
    Eigen::Vector3f along_W = Eigen::Vector3f::Zero();   ///< from the centre to the middle of a side (m)
    Eigen::Vector3f across_W = Eigen::Vector3f::Zero();  ///< likewise to that of a side next to it (m)
};

/// Red, green and blue, 0 to 1. Planes whose ids follow each other differ also for those who do not see all colours;
/// those of the pages in scripts/page. Reentrant. No heap.
std::array<float, 3> plane_colour(std::int32_t id);

/// One entity that replaces the last mesh: faces in the colours of their planes, grey on none. Faces with coordinates
/// that are not finite are left out. About 110 bytes a face. Reentrant. Heap.
std::string mesh_scene(Timestamp stamp, const char* frame, std::span<const SceneFace> faces);

/// One entity that replaces the last planes: for each its rectangle, transparent, and a label with id and kind.
/// Reentrant. Heap.
std::string planes_scene(Timestamp stamp, const char* frame, std::span<const ScenePlane> planes);

}  // namespace facet
