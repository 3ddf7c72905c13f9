// SPDX-License-Identifier: BSD-2-Clause
// How far a plane's surface has been seen to reach.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "mesh/planes/plane_fit.h"

namespace facet {

/// A rectangle around all of a plane's surface that was found, in two axes of the world that lie on the plane as it was
/// found first: of walls one is level and one nearly upright, of other planes the first is that of the largest extent.
/// Surfaces are compared along the one's axes only, so the planes have to face nearly the same way. Reentrant. No heap.
class PlaneReach {
public:
    /// Surfaces no farther apart than this (m) may be ends of one that was seen in parts.
    static constexpr double kBeside_m = 0.5;

    bool empty() const { return box_.isEmpty(); }
    /// The landmarks' rectangle: of an evenly covered one the sides are sqrt(12) standard deviations.
    void extend(const PlaneFit& fit);
    void extend(const PlaneReach& other);
    /// Between the rectangles, 0 if they overlap (m); infinite if one is empty.
    double distance(const PlaneReach& other) const;
    /// Share of the smaller rectangle's area that is within the other one, 0 to 1.
    double overlap(const PlaneReach& other) const;

private:
    Eigen::AlignedBox2d along_own_axes(const PlaneReach& other) const;

    Eigen::Matrix<double, 3, 2> axes_W_ = Eigen::Matrix<double, 3, 2>::Identity();
    Eigen::AlignedBox2d box_;                         ///< along the axes (m)
    Eigen::Vector3d at_W_ = Eigen::Vector3d::Zero();  ///< on the plane: box_ is of the places relative to it
};

}  // namespace facet
