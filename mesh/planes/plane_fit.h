// SPDX-License-Identifier: BSD-2-Clause
// The plane through a set of uncertain points, and how much the points look like one.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

#include "platform/base/status.h"

namespace facet {

/// A point that may lie on a plane.
struct PlanePoint {
    Eigen::Vector3d p_W = Eigen::Vector3d::Zero();           ///< (m)
    Eigen::Matrix3f covariance_W = Eigen::Matrix3f::Zero();  ///< (m^2)

    /// Variance along a unit vector (m^2).
    float variance_along(const Eigen::Vector3f& n) const { return std::max(0.0F, n.dot(covariance_W * n)); }
    /// Standard deviation along a unit vector (m).
    float sigma_along(const Eigen::Vector3f& n) const { return std::sqrt(variance_along(n)); }
};

/// A plane n . p = d with its uncertainty at its points. The axes along, across and normal are orthonormal.
struct PlaneFit {
    Eigen::Vector3d normal_W = Eigen::Vector3d::UnitZ();
    double distance_m = 0.0;
    Eigen::Vector3d centroid_W = Eigen::Vector3d::Zero();  ///< weighted; on the plane after a free fit
    Eigen::Vector3d along_W = Eigen::Vector3d::UnitX();    ///< direction of the largest extent
    Eigen::Vector3d across_W = Eigen::Vector3d::UnitY();
    double sigma_m = 0.0;           ///< of the distance at the centroid
    double sigma_along_rad = 0.0;   ///< of the turn that lifts points farther along
    double sigma_across_rad = 0.0;  ///< likewise across
    double extent_along_m = 0.0;    ///< standard deviation of the points
    double extent_across_m = 0.0;
    double chi2 = 0.0;    ///< squared whitened residual per degree of freedom
    double bend_m = 0.0;  ///< rms of the best quadratic surface against the plane; 0 if noise explains it
    int points = 0;

    /// n . p - d
    double residual(const Eigen::Vector3d& p_W) const { return normal_W.dot(p_W) - distance_m; }
    /// Standard deviation of the plane's height at p, from its own uncertainty (m).
    double sigma_at(const Eigen::Vector3d& p_W) const;
};

/// Fewest points of a fit: three determine a plane, the others show whether it is one.
inline constexpr int kMinFitPoints = 6;

/// Whether a fit asks for the bend, which takes as long as all the rest.
enum class PlaneBend : std::uint8_t { kAsk, kLeave };

/// Weighted least squares: minimises sum w_i (n . p_i - d)^2 / (n' Sigma_i n + s^2), where s is the unevenness of the
/// surface and w_i Huber's weight, in a bounded number of steps from `fit`; each solves for the eigenvectors of the
/// weighted scatter.
/// @param which  indices of the points that take part
/// @param fit    in: normal and distance to start from; out: everything
/// @param bend   kLeave: fit.bend_m stays as it is
/// @return kDegenerate if there are fewer than kMinFitPoints, or they lie nearly on one line (fit untouched).
Status fit_plane(std::span<const PlanePoint> points, std::span<const std::uint16_t> which, double surface_sigma_m,
                 PlaneFit& fit, PlaneBend bend = PlaneBend::kAsk);

/// The bend of a plane that is described: rms of what a quadratic surface explains beyond it, 0 if that is no more than
/// noise would (m).
double bend_of(std::span<const PlanePoint> points, std::span<const std::uint16_t> which, double surface_sigma_m,
               const PlaneFit& fit);

/// Everything but normal and distance, which stay. Errors as above.
Status describe_plane(std::span<const PlanePoint> points, std::span<const std::uint16_t> which, double surface_sigma_m,
                      PlaneFit& fit, PlaneBend bend = PlaneBend::kAsk);

}  // namespace facet
