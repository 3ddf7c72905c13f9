// SPDX-License-Identifier: BSD-2-Clause
// The series behind the figures of an evaluation, as tables for plots.
#pragma once

#include <span>
#include <string>

#include "app/lab/eval/trajectory.h"
#include "app/lab/eval/triangle_tree.h"

namespace facet {

/// A row for every pair: stamp_ns, true_x, true_y, true_z and x, y, z (m; the true and the aligned estimated position,
/// in the true world), error_m, error_deg. Throws InputError if the file cannot be written, as all of these. Heap.
void write_absolute_errors(std::span<const PosePair> pairs, const Se3& T_true_est, const std::string& path);

/// A row for every stretch of every length: length_m, stamp_ns of its beginning, translation_m, translation_percent,
/// rotation_deg, yaw_deg; see relative_error().
void write_relative_errors(std::span<const PosePair> pairs, std::span<const double> lengths_m, const std::string& path);

/// A row for every triangle of the mesh, in its order: distances (m) to the true surface of its corners, corner_0 to
/// corner_2, and of the middles of its sides, side_01, side_12, side_20. At most `limit_m`.
void write_mesh_distances(const TriangleSoup& mesh, const TriangleSoup& surface, const Se3& T_true_est, double limit_m,
                          const std::string& path);

}  // namespace facet
