// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/check/camera_turn.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

#include "estimator/geometry/so3.h"

namespace facet {
namespace {

constexpr std::size_t kMinPoints = 20;
constexpr int kIterations = 12;
constexpr double kScaleRad = 5e-4;  // a quarter of a pixel at usual focal lengths

/// Rotation and direction of translation between two views.
struct RelativePose {
    Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
    Eigen::Vector3d t = Eigen::Vector3d::UnitX();
};

/// Bearings of one point in both views.
struct Bearings {
    Eigen::Vector3d f0;
    Eigen::Vector3d f1;
};

/// Angle of f0 to the plane of t and the turned f1 (rad), and its gradient by the turn and by t.
double epipolar_angle(const RelativePose& pose, const Bearings& b, Eigen::Matrix<double, 3, 2>* gradient) {
    const Eigen::Vector3d normal = b.f0.cross(pose.q * b.f1);
    const double size = std::max(pose.t.cross(b.f0).norm(), 0.05);
    if (gradient != nullptr) {
        // d (t . (f0 x R Exp(d) f1)) = (t x f0) . R (d x f1) = (f1 x R^T (t x f0)) . d
        gradient->col(0) = b.f1.cross(pose.q.conjugate() * pose.t.cross(b.f0)) / size;
        gradient->col(1) = normal / size;
    }
    return pose.t.dot(normal) / size;
}

/// Fits a pose from a start by Gauss-Newton. @return its cost, Cauchy's
double fit_pose(std::span<const Bearings> bearings, RelativePose& pose) {
    for (int iteration = 0; iteration < kIterations; ++iteration) {
        const Eigen::Vector3d b0 = pose.t.unitOrthogonal();
        const Eigen::Vector3d b1 = pose.t.cross(b0);
        // Without parallax the direction of motion means nothing: it is kept from wandering.
        Eigen::Matrix<double, 5, 1> damping;
        damping << 1e-9, 1e-9, 1e-9, 1e-6, 1e-6;
        Eigen::Matrix<double, 5, 5> h = (static_cast<double>(bearings.size()) * damping).asDiagonal();
        Eigen::Matrix<double, 5, 1> g = Eigen::Matrix<double, 5, 1>::Zero();
        for (const Bearings& b : bearings) {
            Eigen::Matrix<double, 3, 2> gradient;
            const double e = epipolar_angle(pose, b, &gradient);
            Eigen::Matrix<double, 5, 1> row;
            row << gradient.col(0), gradient.col(1).dot(b0), gradient.col(1).dot(b1);
            const double w = 1.0 / (1.0 + e * e / (kScaleRad * kScaleRad));
            h += w * row * row.transpose();
            g += w * e * row;
        }
        const Eigen::Matrix<double, 5, 1> step = -h.ldlt().solve(g);
        pose.q = (pose.q * so3_exp(step.head<3>())).normalized();
        pose.t = (pose.t + step(3) * b0 + step(4) * b1).normalized();
        if (step.norm() < 1e-7) {
            break;
        }
    }
    double cost = 0.0;
    for (const Bearings& b : bearings) {
        const double e = epipolar_angle(pose, b, nullptr) / kScaleRad;
        cost += std::log1p(e * e);
    }
    return cost;
}

/// The rotation that explains all of the motion best.
Eigen::Quaterniond pure_rotation(std::span<const Bearings> bearings) {
    Eigen::Matrix3d h = Eigen::Matrix3d::Zero();
    for (const Bearings& b : bearings) {
        h += b.f0 * b.f1.transpose();
    }
    return Eigen::Quaterniond(nearest_orthogonal(h, true));
}

}  // namespace

Eigen::Matrix3d nearest_orthogonal(const Eigen::Matrix3d& h, bool is_rotation) {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(h, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Matrix3d flip = Eigen::Matrix3d::Identity();
    if (is_rotation) {
        flip(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant();
    }
    return svd.matrixU() * flip * svd.matrixV().transpose();
}

std::optional<Eigen::Vector3d> estimate_turn(const CameraModel& camera, std::span<const PointPair> pairs) {
    std::vector<Bearings> bearings;
    for (const PointPair& pair : pairs) {
        Eigen::Vector2d x0;
        Eigen::Vector2d x1;
        if (ok(camera.unproject(pair.first, x0)) && ok(camera.unproject(pair.second, x1))) {
            bearings.push_back({x0.homogeneous().normalized(), x1.homogeneous().normalized()});
        }
    }
    if (bearings.size() < kMinPoints) {
        return std::nullopt;
    }
    RelativePose best;
    double least = std::numeric_limits<double>::max();
    for (int axis = 0; axis < 3; ++axis) {
        RelativePose pose{pure_rotation(bearings), Eigen::Vector3d::Unit(axis)};
        if (const double cost = fit_pose(bearings, pose); cost < least) {
            least = cost;
            best = pose;
        }
    }
    return so3_log(best.q);
}

}  // namespace facet
