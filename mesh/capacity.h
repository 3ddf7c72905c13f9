// SPDX-License-Identifier: BSD-2-Clause
// Every fixed capacity of the mesh in one place, with its reason.
#pragma once

#include "estimator/api/capacity.h"

namespace facet {

/// Points of one triangulation: the features of a frame.
inline constexpr int kMaxMeshPoints = kMaxFeatures;
/// Triangles of one triangulation: a planar triangulation of n points has at most 2n - 5 of them.
inline constexpr int kMaxTriangles = 2 * kMaxMeshPoints;
/// Vertices of the horizon's mesh: the landmarks of the window.
inline constexpr int kMaxMeshVertices = kMaxLandmarks;
/// Faces of the horizon's mesh: four layers of a mesh over all its vertices.
inline constexpr int kMaxMeshFaces = 8192;
/// Sectors of a range sweep: what MAVLink's OBSTACLE_DISTANCE carries.
inline constexpr int kSweepSectors = 72;

}  // namespace facet
