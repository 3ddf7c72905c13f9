// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/geometry/triangulation.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "estimator/geometry/cholesky3.h"

namespace facet {
namespace {

/// Sums over the rows u and v side by side, which fill a vector register, until all sightings are in.
struct ImageSums {
    using Rows = Eigen::Array2d;

    Rows h00 = Rows::Zero();
    Rows h10 = Rows::Zero();
    Rows h11 = Rows::Zero();
    Rows h20 = Rows::Zero();
    Rows h21 = Rows::Zero();
    Rows h22 = Rows::Zero();
    std::array<Rows, 3> g{Rows::Zero(), Rows::Zero(), Rows::Zero()};

    /// @param d  derivative of both rows r by the point's parameters
    void add(const std::array<Rows, 3>& d, const Rows& r, double weight) {
        const Rows wd0 = weight * d[0];
        const Rows wd1 = weight * d[1];
        const Rows wd2 = weight * d[2];
        h00 += wd0 * d[0];
        h10 += wd1 * d[0];
        h11 += wd1 * d[1];
        h20 += wd2 * d[0];
        h21 += wd2 * d[1];
        h22 += wd2 * d[2];
        g[0] += wd0 * r;
        g[1] += wd1 * r;
        g[2] += wd2 * r;
    }
};

/// The lower triangle of H, and g.
struct NormalEquations {
    Eigen::Matrix3d h = Eigen::Matrix3d::Zero();
    Eigen::Vector3d g = Eigen::Vector3d::Zero();

    explicit NormalEquations(const ImageSums& s) : g(s.g[0].sum(), s.g[1].sum(), s.g[2].sum()) {
        h(0, 0) = s.h00.sum();
        h(1, 0) = s.h10.sum();
        h(1, 1) = s.h11.sum();
        h(2, 0) = s.h20.sum();
        h(2, 1) = s.h21.sum();
        h(2, 2) = s.h22.sum();
    }
};

/// Adds one sighting at the point; false if the point is behind the camera.
bool add_sighting(const Sighting& sighting, const InverseDepthPoint& point, const RobustLoss& loss, ImageSums& out) {
    using Rows = ImageSums::Rows;
    const Eigen::Vector3d q = sighting.view->sight_line(point);
    if (!is_in_front(q)) {
        return false;
    }
    const double inv_z = 1.0 / q.z();
    const Rows xy = q.head<2>().array() * inv_z;
    const Rows by_x = sighting.whitening.col(0);
    const Rows by_y = sighting.whitening.col(1);
    const Rows off = xy - sighting.xy.array();
    const Rows r = by_x * off.x() + by_y * off.y();
    const Eigen::Matrix<double, 2, 3> image = sighting.view->d_image_d_point_times_z(xy.matrix());
    const Rows by_x_over_z = inv_z * by_x;
    const Rows by_y_over_z = inv_z * by_y;
    const auto d_r_d = [&](int column) -> Rows {
        return by_x_over_z * image(0, column) + by_y_over_z * image(1, column);
    };
    out.add({d_r_d(0), d_r_d(1), d_r_d(2)}, r, loss.weight((r * r).sum()));
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
        ImageSums sums;
        for (const Sighting& sighting : sightings) {
            if (!add_sighting(sighting, current, options.loss, sums)) {
                return Status::kDegenerate;
            }
        }
        NormalEquations equations(sums);
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
