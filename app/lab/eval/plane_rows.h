// SPDX-License-Identifier: BSD-2-Clause
// planes.csv of a run: what was said of each plane at each keyframe.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "platform/base/timestamp.h"

namespace facet {

/// A row of planes.csv: a plane as reported at one keyframe, in the world of the estimate.
struct PlaneRow {
    Timestamp stamp;
    std::uint32_t id = 0;
    Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
    double distance = 0.0;  ///< (m)
    double landmarks = 0.0;
    double area_m2 = 0.0;                                ///< of its faces
    Eigen::Vector3d centroid = Eigen::Vector3d::Zero();  ///< of its landmarks (m)
};

/// Reads planes.csv by the names of its columns. Throws InputError if it cannot be read or a column is missing.
std::vector<PlaneRow> read_planes(const std::string& path);

}  // namespace facet
