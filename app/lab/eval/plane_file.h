// SPDX-License-Identifier: BSD-2-Clause
// Reads planes.json: the true planes of a scene, or those that a run has found.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>
#include <vector>

namespace facet {

/// A plane normal . x = distance to compare with.
struct EvalPlane {
    std::string name;  ///< "plane ID" if the file has only an id; empty if it has neither
    Eigen::Vector3d normal;
    double distance = 0.0;                  ///< of the plane from the world's origin along its normal (m)
    double seen_m2 = 0.0;                   ///< area of its surface seen in the whole run; 0 if the file does not say
    Eigen::AlignedBox3d box = kEverywhere;  ///< around its surface; everywhere if the file does not say

    static const Eigen::AlignedBox3d kEverywhere;
};

/// Reads planes.json in the format of mesh/README.md, whether the simulator or a run wrote it, and in the older form of
/// true planes: an object whose member "planes" is the array, with "offset" in the place of "distance".
/// @return the planes in the order of the file; none if there is no such file
/// Throws InputError with the file, and the entry by its place from 0, if the file cannot be used.
std::vector<EvalPlane> load_planes(const std::string& path);

}  // namespace facet
