// SPDX-License-Identifier: BSD-2-Clause
// Mesh, planes and times as the values that Foxglove's messages and the live view are made of.
#pragma once

#include <vector>

#include "app/foxglove/messages.h"
#include "app/foxglove/scene.h"
#include "app/output/frame_log.h"
#include "mesh/mesher.h"
#include "mesh/planes/plane_finder.h"

namespace facet {

/// Appends the faces of the mesh over the horizon, as shown. Reentrant. No heap within the vector's capacity.
void append_faces(const Mesher& mesher, std::vector<SceneFace>& faces);

/// Reentrant. No heap.
ScenePlane to_scene(const TrackedPlane& plane);

/// Reentrant. No heap.
MessageTimes to_message_times(const FrameTiming& timing);

}  // namespace facet
