// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/geometry/triangulation.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace facet {
namespace {

constexpr double kMinCosine = 0.05;  // least forward part of a sight line, relative to the ray's length

struct NormalEquations {
    Eigen::Matrix3d h = Eigen::Matrix3d::Zero();
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
};

/// Adds one sighting at the point; false if the point is behind the camera.
bool add_sighting(const Sighting& sighting, const CameraPose& host, const ScaledWorldPoint& point, double huber,
                  NormalEquations& out) {
    const Eigen::Matrix3d& R_C_W = sighting.camera->R_C_W;
    const Eigen::Vector3d q = R_C_W * point.from(sighting.camera->p_W_C);
    if (!(q.z() > kMinCosine * q.norm())) {
        return false;
    }
    const double inv_z = 1.0 / q.z();
    const Eigen::Vector2d xy = q.head<2>() * inv_z;
    const Eigen::Vector2d r = sighting.scale * (xy - sighting.xy);
    const double norm = r.norm();
    const double weight = norm <= huber ? 1.0 : huber / norm;

    Eigen::Matrix3d d_q_d_point;  // columns x, y, rho
    d_q_d_point.leftCols<2>() = (R_C_W * host.R_C_W.transpose()).leftCols<2>();
    d_q_d_point.col(2) = R_C_W * (host.p_W_C - sighting.camera->p_W_C);
    Eigen::Matrix<double, 2, 3> d_r_d_point;
    d_r_d_point.row(0) = sighting.scale * inv_z * (d_q_d_point.row(0) - xy.x() * d_q_d_point.row(2));
    d_r_d_point.row(1) = sighting.scale * inv_z * (d_q_d_point.row(1) - xy.y() * d_q_d_point.row(2));
    out.h.noalias() += weight * d_r_d_point.transpose() * d_r_d_point;
    out.g.noalias() += weight * d_r_d_point.transpose() * r;
    return true;
}

/// Adds the plane's residual (n . (centre + ray / rho - o) - h) / sigma; none for a point practically at infinity.
void add_plane(const TriangulationOptions& options, const CameraPose& host, const ScaledWorldPoint& point,
               NormalEquations& out) {
    constexpr double kMinRho = 0.01;  // 1/m
    if (point.rho <= kMinRho) {
        return;
    }
    const double r = options.plane->height(point.p_W()) / options.plane_sigma_m;
    const double weight =
        std::abs(r) <= options.plane_huber_threshold ? 1.0 : options.plane_huber_threshold / std::abs(r);
    const Eigen::Vector3d n_H = host.R_C_W * options.plane->normal_W() / (options.plane_sigma_m * point.rho);
    const double along_ray = n_H.dot(host.R_C_W * point.ray_W);
    const Eigen::Vector3d d_r_d_point(n_H.x(), n_H.y(), -along_ray / point.rho);
    out.h.noalias() += weight * d_r_d_point * d_r_d_point.transpose();
    out.g.noalias() += weight * r * d_r_d_point;
}

}  // namespace

Status triangulate_linear(std::span<const Sighting> sightings, InverseDepthPoint& point) {
    if (sightings.size() < 2) {
        return Status::kDegenerate;
    }
    const CameraPose& host = *sightings.front().camera;
    const Eigen::Vector3d ray_W = host.R_C_W.transpose() * sightings.front().xy.homogeneous();
    double numerator = 0.0;
    double denominator = 0.0;
    for (const Sighting& s : sightings.subspan(1)) {
        // (m + rho t) x (xy, 1) = 0, its first two rows: m.xy - m.z xy + rho (t.xy - t.z xy) = 0
        const Eigen::Vector3d m = s.camera->R_C_W * ray_W;
        const Eigen::Vector3d t = s.camera->R_C_W * (host.p_W_C - s.camera->p_W_C);
        const Eigen::Vector2d a = m.head<2>() - m.z() * s.xy;
        const Eigen::Vector2d b = t.head<2>() - t.z() * s.xy;
        numerator -= b.dot(a);
        denominator += b.squaredNorm();
    }
    if (!(denominator > 1e-10)) {
        return Status::kDegenerate;
    }
    point.xy = sightings.front().xy;
    point.rho = std::max(0.0, numerator / denominator);
    return Status::kOk;
}

Status triangulate(std::span<const Sighting> sightings, const TriangulationOptions& options, InverseDepthPoint& point) {
    constexpr double kStepTolerance = 1e-7;
    const CameraPose& host = *sightings.front().camera;
    const double rho_information = 1.0 / (options.rho_prior_sigma * options.rho_prior_sigma);
    InverseDepthPoint current = point;
    for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
        const ScaledWorldPoint world(host, current);
        NormalEquations equations;
        for (const Sighting& sighting : sightings) {
            if (!add_sighting(sighting, host, world, options.huber_threshold, equations)) {
                return Status::kDegenerate;
            }
        }
        if (options.plane != nullptr) {
            add_plane(options, host, world, equations);
        }
        equations.h(2, 2) += rho_information;
        equations.g(2) += rho_information * current.rho;
        const Eigen::Vector3d step = equations.h.ldlt().solve(-equations.g);
        if (!step.allFinite()) {
            return Status::kDegenerate;
        }
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
