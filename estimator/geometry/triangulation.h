// SPDX-License-Identifier: BSD-2-Clause
// Multi-view triangulation of one landmark from cameras of known pose.
#pragma once

#include <span>

#include "estimator/geometry/plane_chart.h"
#include "estimator/geometry/relative_view.h"
#include "estimator/geometry/robust_loss.h"
#include "platform/base/status.h"

namespace facet {

/// One sighting of a landmark: where a camera of known pose, relative to the host, saw it.
struct Sighting {
    const RelativeView* view = nullptr;
    Eigen::Vector2d xy = Eigen::Vector2d::Zero();  ///< normalised, undistorted (-)
    /// Of the pixel by xy, over the pixel's standard deviation.
    Eigen::Matrix2d whitening = Eigen::Matrix2d::Identity();
};

struct TriangulationOptions {
    int max_iterations = 5;  ///< Gauss-Newton steps
    RobustLoss loss;
    double max_rho = 10.0;  ///< nearest point accepted: 1 / depth (1/m)
    /// Standard deviation of a zero-mean prior on rho (1/m): puts a landmark without parallax at infinity, instead of
    /// anywhere; far wider than the uncertainty that any real baseline leaves.
    double rho_prior_sigma = 3.0;
    /// Plane that the point should lie on, or nullptr: one more residual huber(|height / plane_sigma_m|^2).
    const PlaneChart* plane = nullptr;
    double plane_sigma_m = 0.01;
    double plane_huber_threshold = 1.5;  ///< standard deviations
};

/// First guess of rho by linear least squares along the host's ray (the host's own sighting is sightings[0]).
/// @return kDegenerate if no sighting has a baseline to the host (outputs untouched).
Status triangulate_linear(std::span<const Sighting> sightings, InverseDepthPoint& point);

/// Minimises sum rho(|whitening (project(point) - xy)|^2), and the plane's residual if there is one, over the point by
/// Gauss-Newton, from the point given. Points beyond infinity are put at infinity (rho = 0).
/// @return kDegenerate if the point is behind a camera, nearer than 1 / max_rho, or not finite (outputs untouched).
/// No heap. Reentrant.
Status triangulate(std::span<const Sighting> sightings, const TriangulationOptions& options, InverseDepthPoint& point);

}  // namespace facet
