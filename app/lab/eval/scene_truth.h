// SPDX-License-Identifier: BSD-2-Clause
// Loads what mesh evaluation compares with.
#pragma once

#include <string>
#include <vector>

#include "app/lab/eval/mesh_accuracy.h"

namespace facet {

/// Reads a PLY file. Throws InputError if it cannot be used or holds no triangle.
TriangleSoup load_mesh(const std::string& path);

/// The true surface of scene_ply and the planes of planes.json beside it, none if there is no such file. The views are
/// the true poses between the first and the last of `pairs`, pose_interval_s apart. Throws InputError.
SceneTruth load_scene(const std::string& scene_ply, const CameraModel& left, const Se3& T_B_C0,
                      const std::vector<PosePair>& pairs, double pose_interval_s);

}  // namespace facet
