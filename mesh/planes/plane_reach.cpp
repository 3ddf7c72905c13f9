// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/planes/plane_reach.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace facet {

void PlaneReach::extend(const PlaneFit& fit) {
    constexpr double kWall = 0.7;  // a normal less upright than this
    if (empty()) {
        const Eigen::Vector3d n = fit.normal_W;
        const Eigen::Vector3d first =
            std::abs(n.z()) < kWall ? Eigen::Vector3d::UnitZ().cross(n).normalized() : fit.along_W;
        axes_W_ << first, n.cross(first).normalized();
        at_W_ = fit.centroid_W;
    }
    const Eigen::Vector2d centre = axes_W_.transpose() * (fit.centroid_W - at_W_);
    const Eigen::Vector2d half =
        std::sqrt(3.0) * (fit.extent_along_m * (axes_W_.transpose() * fit.along_W).cwiseAbs() +
                          fit.extent_across_m * (axes_W_.transpose() * fit.across_W).cwiseAbs());
    box_.extend(Eigen::Vector2d(centre - half)).extend(Eigen::Vector2d(centre + half));
}

Eigen::AlignedBox2d PlaneReach::along_own_axes(const PlaneReach& other) const {
    Eigen::AlignedBox2d box;
    for (const auto corner : {Eigen::AlignedBox2d::BottomLeft, Eigen::AlignedBox2d::BottomRight,
                              Eigen::AlignedBox2d::TopLeft, Eigen::AlignedBox2d::TopRight}) {
        const Eigen::Vector3d p_W = other.at_W_ + other.axes_W_ * other.box_.corner(corner);
        box.extend(Eigen::Vector2d(axes_W_.transpose() * (p_W - at_W_)));
    }
    return box;
}

void PlaneReach::extend(const PlaneReach& other) {
    if (empty()) {
        *this = other;
    } else if (!other.empty()) {
        box_.extend(along_own_axes(other));
    }
}

double PlaneReach::distance(const PlaneReach& other) const {
    if (empty() || other.empty()) {
        return std::numeric_limits<double>::infinity();
    }
    return box_.exteriorDistance(along_own_axes(other));
}

double PlaneReach::overlap(const PlaneReach& other) const {
    if (empty() || other.empty()) {
        return 0.0;
    }
    const Eigen::AlignedBox2d box = along_own_axes(other);
    const Eigen::AlignedBox2d both = box_.intersection(box);
    const double smaller = std::min(box_.volume(), box.volume());
    return both.isEmpty() || !(smaller > 0.0) ? 0.0 : std::min(1.0, both.volume() / smaller);
}

}  // namespace facet
