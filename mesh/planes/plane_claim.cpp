// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/planes/plane_claim.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "estimator/geometry/lens_correction.h"
#include "estimator/values/stereo_depth.h"

namespace facet {
namespace {

constexpr double kShared = 0.1;      // of the error of any two heights above a plane
constexpr double kSpread = 1.2;      // standard deviations of the landmarks: where their plane is looked at
constexpr double kLeastDepth = 0.1;  // m
constexpr int kLeastPoints = 4;

/// How the height of a point of the plane changes with the cameras' parameters: the point is (x + dx, 1) / rho.
CamerasRow height_of(const Eigen::Vector3d& p_C0, const Eigen::Vector3d& n_C0, const StereoRig& rig) {
    const double rho = 1.0 / p_C0.z();
    const Eigen::Vector3d x = rho * p_C0;
    CamerasRow d_height = -n_C0.dot(x) / (rho * rho) * d_inverse_depth_d_cameras(p_C0, rig);
    d_height.head<kLensDim>() += n_C0.head<2>().transpose() * d_xy_d_lens(rig.left, x.head<2>()).cast<double>() / rho;
    return d_height;
}

double root(double variance) { return std::sqrt(std::max(0.0, variance)); }

}  // namespace

PlaneCovariance effect_of_calibration(const PlaneFit& fit, const StereoRig& rig, const CameraCorrections& cameras,
                                      const Se3& T_W_C0) {
    const Se3 T_C0_W = T_W_C0.inverse();
    const Se3 T_C1_C0 = rig.T_C1_C0();
    const Eigen::Vector3d n_C0 = T_C0_W.q * fit.normal_W;
    Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
    Eigen::Matrix<double, 3, CameraCorrections::kDim> effect =
        Eigen::Matrix<double, 3, CameraCorrections::kDim>::Zero();
    int points = 0;
    for (int i = -1; i <= 1; ++i) {
        for (int j = -1; j <= 1; ++j) {
            const Eigen::Vector3d at(1.0, kSpread * i * fit.extent_along_m, kSpread * j * fit.extent_across_m);
            const Eigen::Vector3d p_C0 = T_C0_W * (fit.centroid_W + at[1] * fit.along_W + at[2] * fit.across_W);
            if (p_C0.z() < kLeastDepth || (T_C1_C0 * p_C0).z() < kLeastDepth) {
                continue;
            }
            moment += at * at.transpose();
            effect += at * height_of(p_C0, n_C0, rig);
            ++points;
        }
    }
    const Eigen::LDLT<Eigen::Matrix3d> solver(moment);
    if (points < kLeastPoints || !(solver.rcond() > 1e-9)) {
        return PlaneCovariance::Zero();
    }
    const Eigen::Matrix<double, 3, CameraCorrections::kDim> d_plane = solver.solve(effect);
    return d_plane * cameras.covariance * d_plane.transpose();
}

PlaneFit claimed_in_world(const PlaneFit& fit, const SightedFrom& from, const PlaneCovariance& calibration) {
    const double alike = 1.0 + kShared * std::max(0, fit.points - 1);
    const Eigen::Matrix2d drift = from.effect_at(fit.centroid_W, fit.normal_W);
    // A turn about the vertical changes the normal by z x n.
    const Eigen::Vector3d turned = Eigen::Vector3d::UnitZ().cross(fit.normal_W) * root(drift(1, 1));
    PlaneFit claim = fit;
    claim.sigma_m = root(alike * std::pow(fit.sigma_m, 2) + drift(0, 0) + calibration(0, 0));
    claim.sigma_along_rad =
        root(alike * std::pow(fit.sigma_along_rad, 2) + std::pow(fit.along_W.dot(turned), 2) + calibration(1, 1));
    claim.sigma_across_rad =
        root(alike * std::pow(fit.sigma_across_rad, 2) + std::pow(fit.across_W.dot(turned), 2) + calibration(2, 2));
    return claim;
}

}  // namespace facet
