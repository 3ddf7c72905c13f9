// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/geometry/triangulation.h"

#include <algorithm>
#include <cmath>

#include "estimator/geometry/cholesky3.h"

namespace facet {
namespace {

struct NormalEquations {
    Eigen::Matrix3d h = Eigen::Matrix3d::Zero();
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
};

/// Adds one sighting at the point; false if the point is behind the camera.
bool add_sighting(const Sighting& sighting, const InverseDepthPoint& point, const RobustLoss& loss,
                  NormalEquations& out) {
    const Eigen::Vector3d q = sighting.view->sight_line(point);
    if (!is_in_front(q)) {
        return false;
    }
    const double inv_z = 1.0 / q.z();
    const Eigen::Vector2d xy = q.head<2>() * inv_z;
    const Eigen::Vector2d r = sighting.whitening * (xy - sighting.xy);
    const double weight = loss.weight(r.squaredNorm());
    const Eigen::Matrix2d d_r_d_image_over_z = inv_z * sighting.whitening;
    const Eigen::Matrix<double, 2, 3> d_r_d_point =
        d_r_d_image_over_z.lazyProduct(sighting.view->d_image_d_point_times_z(xy));
    out.h.noalias() += (weight * d_r_d_point.transpose()).lazyProduct(d_r_d_point);
    out.g.noalias() += d_r_d_point.transpose().lazyProduct(weight * r);
    return true;
}

/// Adds the plane's residual height / sigma, unless the point is practically at infinity.
void add_plane(const TriangulationOptions& options, const InverseDepthPoint& point, NormalEquations& out) {
    if (point.rho <= PlaneChart::kMinRho) {
        return;
    }
    const double r = options.plane->height(point) / options.plane_sigma_m;
    const double weight = HuberLoss{options.plane_huber_threshold}.weight(r * r);
    const Eigen::Vector3d d_r_d_point = options.plane->d_height_d_point(point).transpose() / options.plane_sigma_m;
    out.h.noalias() += weight * d_r_d_point * d_r_d_point.transpose();
    out.g.noalias() += weight * r * d_r_d_point;
}

}  // namespace

Status triangulate_linear(std::span<const Sighting> sightings, InverseDepthPoint& point) {
    if (sightings.size() < 2) {
        return Status::kDegenerate;
    }
    const Eigen::Vector2d& host_xy = sightings.front().xy;
    double numerator = 0.0;
    double denominator = 0.0;
    for (const Sighting& s : sightings.subspan(1)) {
        // (m + rho t) x (xy, 1) = 0, its first two rows: m.xy - m.z xy + rho (t.xy - t.z xy) = 0
        const Eigen::Vector3d m = s.view->sight_line({host_xy, 0.0});
        const Eigen::Vector3d t = s.view->T_C_H.topRightCorner<3, 1>();
        const Eigen::Vector2d a = m.head<2>() - m.z() * s.xy;
        const Eigen::Vector2d b = t.head<2>() - t.z() * s.xy;
        numerator -= b.dot(a);
        denominator += b.squaredNorm();
    }
    if (!(denominator > 1e-10)) {
        return Status::kDegenerate;
    }
    point.xy = host_xy;
    point.rho = std::max(0.0, numerator / denominator);
    return Status::kOk;
}

Status triangulate(std::span<const Sighting> sightings, const TriangulationOptions& options, InverseDepthPoint& point) {
    constexpr double kStepTolerance = 1e-6;  // a thousandth of a pixel at most
    const double rho_information = 1.0 / (options.rho_prior_sigma * options.rho_prior_sigma);
    InverseDepthPoint current = point;
    for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
        NormalEquations equations;
        for (const Sighting& sighting : sightings) {
            if (!add_sighting(sighting, current, options.loss, equations)) {
                return Status::kDegenerate;
            }
        }
        if (options.plane != nullptr) {
            add_plane(options, current, equations);
        }
        equations.h(2, 2) += rho_information;
        equations.g(2) += rho_information * current.rho;
        Cholesky3 cholesky;
        FACET_TRY(cholesky.factorize(equations.h));
        const Eigen::Vector3d step = cholesky.solve(-equations.g);
        current.xy += step.head<2>();
        current.rho = std::max(0.0, current.rho + step.z());
        if (step.squaredNorm() < kStepTolerance * kStepTolerance) {
            break;
        }
    }
    if (!(current.rho <= options.max_rho) || !current.xy.allFinite()) {
        return Status::kDegenerate;
    }
    point = current;
    return Status::kOk;
}

}  // namespace facet
