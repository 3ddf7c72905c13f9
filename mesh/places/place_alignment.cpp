// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/places/place_alignment.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "mesh/places/patch_search.h"

namespace facet {
namespace {

/// What alignment across two views leaves (px), and what the point's own direction has.
constexpr double kAlignedSigma = 0.3;
constexpr double kGate2 = 9.21;  ///< 99 % of chi squared with two degrees of freedom
constexpr int kFitSteps = 6;
constexpr double kLeastShare = 0.5;

/// Share of the depths' sigma that the points of a view have in common.
constexpr double kSharedDepth = 0.6;

double mean_depth_sigma(const PlaceView& view) {
    double sum = 0.0;
    for (const PlacePoint& point : view.points) {
        sum += static_cast<double>(point.depth_sigma);
    }
    return sum / static_cast<double>(view.points.size());
}

/// A point of the place and where the image has it.
struct Sighting {
    Eigen::Vector3d p_K;
    double depth_sigma = 0.0;
    Eigen::Vector2d xy;
};
using Sightings = FixedVector<Sighting, kMaxPlacePoints>;

/// The error of a sighting, its derivative by the pose, and its information. @return false if it is behind the camera
bool error_of(const Sighting& s, const YawPose& T_K_G, const Eigen::Matrix3d& R_C_G, double pixel, Eigen::Vector2d& e,
              Eigen::Matrix2d& information, Eigen::Matrix<double, 2, 4>& j) {
    const Eigen::Matrix3d R_G_K = yaw_matrix(-T_K_G.yaw);
    const Eigen::Vector3d p_G = R_G_K * (s.p_K - T_K_G.p);
    const Eigen::Vector3d p_C = R_C_G * p_G;
    constexpr double kNear_m = 0.05;
    if (p_C.z() < kNear_m) {
        return false;
    }
    const Eigen::Vector2d xy = p_C.head<2>() / p_C.z();
    e = xy - s.xy;
    Eigen::Matrix<double, 2, 3> d_d_p;
    d_d_p << 1.0, 0.0, -xy.x(), 0.0, 1.0, -xy.y();
    d_d_p /= p_C.z();
    const Eigen::Matrix<double, 2, 3> d_d_K = d_d_p * R_C_G * R_G_K;
    j.col(0) = d_d_p * (R_C_G * Eigen::Vector3d(p_G.y(), -p_G.x(), 0.0));
    j.rightCols<3>() = -d_d_K;
    const Eigen::Vector2d along = d_d_K * s.p_K * s.depth_sigma;
    const double across = pixel * s.p_K.norm();
    information = (pixel * pixel * Eigen::Matrix2d::Identity() + along * along.transpose() +
                   across * across * d_d_K * d_d_K.transpose())
                      .inverse();
    return true;
}

}  // namespace

Status align_place(const ImagePyramid& pyramid, const CameraModel& camera, const Eigen::Quaternionf& q_G_C,
                   const PlaceView& known, PlacePose& pose) {
    const Eigen::Matrix3d R_C_G = q_G_C.toRotationMatrix().transpose().cast<double>();
    const Eigen::Vector3d down_C = -R_C_G.col(2);
    const YawPose T_G_K = pose.T_K_G.inverse();
    Sightings sightings;
    int looked_for = 0;
    for (const PlacePoint& point : known.points) {
        UprightSquare square;
        Sighting s{point.p_G.cast<double>(), static_cast<double>(point.depth_sigma), {}};
        Eigen::Vector2d uv;
        if (!ok(upright_square(camera, R_C_G * (T_G_K * s.p_K), down_C, square)) ||
            !camera.in_image(square.centre, 0.0)) {
            continue;
        }
        ++looked_for;
        if (ok(search_patch(pyramid, square, point.code.octave, point.patch, uv)) && ok(camera.unproject(uv, s.xy))) {
            sightings.push_back(s);
        }
    }
    const double pixel = kAlignedSigma / camera.focal_px();
    YawPose fitted = pose.T_K_G;
    YawPose::Covariance h;
    int inliers = 0;
    double chi2 = 0.0;
    for (int step = 0; step < kFitSteps; ++step) {
        h = YawPose::Covariance::Identity() * 1e-9;
        YawPose::Tangent b = YawPose::Tangent::Zero();
        inliers = 0;
        chi2 = 0.0;
        for (const Sighting& s : sightings) {
            Eigen::Vector2d e;
            Eigen::Matrix2d information;
            Eigen::Matrix<double, 2, 4> j;
            if (!error_of(s, fitted, R_C_G, pixel, e, information, j)) {
                continue;
            }
            const double squared = e.dot(information * e);
            const double weight = 1.0 / (1.0 + squared / kGate2);
            if (squared < kGate2) {
                ++inliers;
                chi2 += squared;
            }
            h += weight * j.transpose() * information * j;
            b -= weight * j.transpose() * information * e;
        }
        fitted = fitted.box_plus(h.ldlt().solve(b));
    }
    if (inliers < kMinInliers || inliers < kLeastShare * static_cast<double>(sightings.size())) {
        return Status::kDegenerate;
    }
    // Depths of one view share part of their errors: a common scale of what the view has moved.
    const double shared = kSharedDepth * mean_depth_sigma(known) * fitted.p.norm();
    const double scale = std::max(1.0, chi2 / (2.0 * inliers - 4.0));
    YawPose::Covariance covariance = h.inverse() * scale;
    covariance.bottomRightCorner<3, 3>() += shared * shared * Eigen::Matrix3d::Identity();
    pose = {fitted, covariance, looked_for, inliers};
    return Status::kOk;
}

}  // namespace facet
