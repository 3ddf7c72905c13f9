// SPDX-License-Identifier: BSD-2-Clause
// Every fixed capacity of the mesh in one place, with its reason.
#pragma once

#include "estimator/values/capacity.h"

namespace facet {

/// Points of one triangulation: the features of a frame and the surface points between them.
inline constexpr int kMaxMeshPoints = kMaxFeatures + kMaxSurfacePoints;
/// Triangles of one triangulation: a planar triangulation of n points has at most 2n - 5 of them.
inline constexpr int kMaxTriangles = 2 * kMaxMeshPoints;
/// Vertices of the horizon's mesh: the landmarks of the window and as many surface points.
inline constexpr int kMaxMeshVertices = 2 * kMaxLandmarks;
/// Faces of the horizon's mesh: a mesh over all its vertices.
inline constexpr int kMaxMeshFaces = 8192;
/// Points among which planes are searched: landmarks and, while there is room, surface points.
inline constexpr int kMaxPlanePoints = kMaxMeshVertices;
/// Points of one keyframe's semi-dense depth: 1800 squares of 14 pixels in an image of 752 x 480, and
/// room for more.
inline constexpr int kMaxDepthPoints = 4096;
/// Sectors of a range sweep: what MAVLink's OBSTACLE_DISTANCE carries.
inline constexpr int kSweepSectors = 72;

}  // namespace facet
