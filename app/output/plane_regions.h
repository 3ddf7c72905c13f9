// SPDX-License-Identifier: BSD-2-Clause
// The surface of a plane as polygons: what a person or a planner takes for the table, or for the door in the wall.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "app/output/plane_raster.h"
#include "mesh/planes/plane_finder.h"

namespace facet {

/// Axes on a plane, in the world of the estimate: the first two span it, the third is its normal; right-handed. On
/// walls the first is level and the second points up, elsewhere the first runs along the landmarks' largest extent.
struct PlaneAxes {
    Eigen::Vector3d origin_W = Eigen::Vector3d::Zero();    ///< centroid of the landmarks, on the plane
    Eigen::Matrix3d R_W_A = Eigen::Matrix3d::Identity();   ///< the axes as columns
    Eigen::Vector2d sigma_turn = Eigen::Vector2d::Zero();  ///< of the turn that lifts points along each axis (rad)

    PlaneAxes(const PlaneFit& fit, PlaneKind kind);
    Eigen::Vector2d to_plane(const Eigen::Vector3d& p_W) const {
        return (R_W_A.transpose() * (p_W - origin_W)).head<2>();
    }
    Eigen::Vector3d to_world(const Eigen::Vector2d& a) const { return origin_W + R_W_A.leftCols<2>() * a; }
};

/// A connected part of a plane, in its axes.
struct PlaneRegion {
    double area_m2 = 0.0;          ///< without the holes
    PlaneRing boundary;            ///< counterclockwise as seen from the side that the normal points to
    std::vector<PlaneRing> holes;  ///< clockwise
};

struct PlaneRegionOptions {
    double cell_m = 0.01;        ///< raster of the plane (PlaneRaster)
    double gap_m = 0.06;         ///< narrower gaps are closed: faces of different keyframes do not quite meet
    double tolerance_m = 0.015;  ///< by which the outline may differ from that of the cells
    double min_area_m2 = 0.02;   ///< smaller regions and holes are left out
};

/// The regions that triangles cover, largest first, with corners at whole millimetres. Their lines do not cross.
/// Triangles that are not finite are left out. Heap. Reentrant.
std::vector<PlaneRegion> find_plane_regions(std::span<const PlaneTriangle> triangles,
                                            const PlaneRegionOptions& options = {});

/// The region cut into triangles, exact to a millimetre. Heap. Reentrant.
std::vector<PlaneTriangle> triangulate(const PlaneRegion& region);

}  // namespace facet
