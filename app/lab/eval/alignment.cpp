// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/alignment.h"

#include <Eigen/Eigenvalues>

#include "app/lab/eval/pose_difference.h"

namespace facet {
namespace {

/// First and second moments of the paired positions.
struct Moments {
    Eigen::Vector3d mean_truth = Eigen::Vector3d::Zero();
    Eigen::Vector3d mean_estimate = Eigen::Vector3d::Zero();
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< mean of (t - mean_t) (e - mean_e)^T
    double estimate_variance = 0.0;                        ///< mean of |e - mean_e|^2
};

Moments moments(std::span<const PosePair> pairs) {
    Moments m;
    const double weight = 1.0 / static_cast<double>(pairs.size());
    for (const PosePair& pair : pairs) {
        m.mean_truth += weight * pair.truth.p;
        m.mean_estimate += weight * pair.estimate.p;
    }
    for (const PosePair& pair : pairs) {
        const Eigen::Vector3d e = pair.estimate.p - m.mean_estimate;
        m.covariance += weight * (pair.truth.p - m.mean_truth) * e.transpose();
        m.estimate_variance += weight * e.squaredNorm();
    }
    return m;
}

/// Rotation that maximises trace(R^T C), as the eigenvector of the largest eigenvalue of a symmetric 4x4 matrix
/// [Horn87] section 4; the eigenvalue is that largest trace, which gives the similarity's scale.
Eigen::Quaterniond best_rotation(const Eigen::Matrix3d& covariance, double& largest_trace) {
    const Eigen::Matrix3d s = covariance.transpose();  // s(i, j) = mean e_i t_j
    Eigen::Matrix4d n;
    n(0, 0) = s.trace();
    n.bottomRightCorner<3, 3>() = s + s.transpose() - s.trace() * Eigen::Matrix3d::Identity();
    n.bottomLeftCorner<3, 1>() << s(1, 2) - s(2, 1), s(2, 0) - s(0, 2), s(0, 1) - s(1, 0);
    n.topRightCorner<1, 3>() = n.bottomLeftCorner<3, 1>().transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(n);
    largest_trace = solver.eigenvalues()(3);
    const Eigen::Vector4d q = solver.eigenvectors().col(3);
    return Eigen::Quaterniond(q(0), q(1), q(2), q(3)).normalized();
}

}  // namespace

const char* to_string(AlignmentMode mode) {
    switch (mode) {
        case AlignmentMode::kSe3: return "SE(3), no scale";
        case AlignmentMode::kYaw4: return "4-DoF (yaw + translation), no scale";
    }
    return "?";
}

Se3 align(std::span<const PosePair> pairs, AlignmentMode mode) {
    Se3 T_true_est;
    if (pairs.empty()) {
        return T_true_est;
    }
    const Moments m = moments(pairs);
    if (mode == AlignmentMode::kSe3) {
        double unused = 0.0;
        T_true_est.q = best_rotation(m.covariance, unused);
    } else {
        const double yaw = nearest_yaw(m.covariance);
        T_true_est.q = Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
    }
    T_true_est.p = m.mean_truth - T_true_est.q * m.mean_estimate;
    return T_true_est;
}

double similarity_scale(std::span<const PosePair> pairs) {
    if (pairs.empty()) {
        return 1.0;
    }
    const Moments m = moments(pairs);
    double largest_trace = 0.0;
    best_rotation(m.covariance, largest_trace);
    return m.estimate_variance > 0.0 ? largest_trace / m.estimate_variance : 1.0;
}

}  // namespace facet
