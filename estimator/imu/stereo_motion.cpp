// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/imu/stereo_motion.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "estimator/geometry/so3.h"
#include "estimator/values/capacity.h"
#include "platform/base/fixed_vector.h"

namespace facet {
namespace {

constexpr std::size_t kMinPoints = 6;
constexpr std::size_t kHypotheses = 48;
constexpr int kRefineSteps = 4;
// Covariances are evaluated at measured depths: points whose depth is underestimated get too much weight. Monte Carlo
// over 1 to 12 m at a baseline of 0.1 m gives squared errors 1.8 times what the sum of weights says with the rotation
// open.
constexpr double kCovarianceScale = 1.4;
constexpr double kChiSquared3 = 11.34;  // 99 % of chi^2 with 3 degrees of freedom

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// A point in body frames, with the information of p_Bi - R p_Bj.
struct BodyPoint {
    Eigen::Vector3d then;
    Eigen::Vector3d now;
    Eigen::Matrix3d information;
};

using BodyPoints = FixedVector<BodyPoint, kMaxFeatures>;

bool is_possible(const StereoPlace& place) {
    return place.p_C0.allFinite() && place.covariance_C0.allFinite() && place.p_C0.z() > 0.0;
}

void to_body(std::span<const StereoPoint> points, const Se3& T_B_C, const Eigen::Quaterniond& q_Bi_Bj,
             BodyPoints& out) {
    const Eigen::Matrix3d R_B_C = T_B_C.q.toRotationMatrix();
    const Eigen::Matrix3d R_Bi_Cj = q_Bi_Bj.toRotationMatrix() * R_B_C;
    for (const StereoPoint& point : points) {
        if (out.size() == kMaxFeatures) {
            return;
        }
        if (!is_possible(point.then) || !is_possible(point.now)) {
            continue;
        }
        const Eigen::Matrix3d covariance = R_B_C * point.then.covariance_C0 * R_B_C.transpose() +
                                           R_Bi_Cj * point.now.covariance_C0 * R_Bi_Cj.transpose();
        out.push_back({T_B_C * point.then.p_C0, T_B_C * point.now.p_C0, covariance.inverse()});
    }
}

/// How far a point is from a motion: Mahalanobis, squared; the rotation's uncertainty counted as the point's.
double distance(const BodyPoint& point, const Eigen::Quaterniond& q, const Eigen::Vector3d& t, double rotation_sigma) {
    const Eigen::Vector3d d = point.then - q * point.now - t;
    // (information^-1 + s^2 I)^-1 without inverting twice: s^2 as the variance along d
    const double along = d.squaredNorm();
    const double weight = d.dot(point.information * d);
    const double s2 = rotation_sigma * rotation_sigma * point.now.squaredNorm();
    return along > 0.0 ? weight / (1.0 + s2 * weight / along) : 0.0;
}

/// Best of the translations that single points give.
Eigen::Vector3d best_hypothesis(const BodyPoints& points, const Eigen::Quaterniond& q, double rotation_sigma) {
    const std::size_t stride = std::max<std::size_t>(1, points.size() / kHypotheses);
    Eigen::Vector3d best = Eigen::Vector3d::Zero();
    double best_score = -1.0;
    for (std::size_t i = 0; i < points.size(); i += stride) {
        const Eigen::Vector3d t = points[i].then - q * points[i].now;
        double score = 0.0;
        for (const BodyPoint& point : points) {
            // the hypothesis itself has the error of a point: twice the variance
            score += std::max(0.0, 1.0 - 0.5 * distance(point, q, t, rotation_sigma) / kChiSquared3);
        }
        if (score > best_score) {
            best_score = score;
            best = t;
        }
    }
    return best;
}

}  // namespace

Status StereoMotionConfig::validate() const { return validate_fields(kStereoMotionFields, *this); }

Status estimate_stereo_motion(std::span<const StereoPoint> points, const Se3& T_B_C, const Eigen::Quaterniond& q_Bi_Bj,
                              const StereoMotionConfig& config, StereoMotion& out) {
    BodyPoints body;
    to_body(points, T_B_C, q_Bi_Bj, body);
    if (body.size() < kMinPoints) {
        return Status::kDegenerate;
    }
    StereoMotion m;
    m.q_Bi_Bj = q_Bi_Bj;
    m.p_Bi_Bj = best_hypothesis(body, q_Bi_Bj, config.rotation_sigma_rad);
    const double prior = 1.0 / (config.rotation_sigma_rad * config.rotation_sigma_rad);
    // The rotation's uncertainty widens the first gate only: afterwards the points have fixed it.
    double rotation_sigma = config.rotation_sigma_rad;
    for (int step = 0; step < kRefineSteps; ++step) {
        Matrix6 h = Matrix6::Zero();
        Vector6 b = Vector6::Zero();
        h.topLeftCorner<3, 3>().diagonal().setConstant(prior);
        b.head<3>() = -prior * so3_log(q_Bi_Bj.conjugate() * m.q_Bi_Bj);
        const Eigen::Matrix3d R = m.q_Bi_Bj.toRotationMatrix();
        m.inliers = 0;
        for (const BodyPoint& point : body) {
            if (distance(point, m.q_Bi_Bj, m.p_Bi_Bj, rotation_sigma) > kChiSquared3) {
                continue;
            }
            const Eigen::Vector3d r = point.then - R * point.now - m.p_Bi_Bj;
            Eigen::Matrix<double, 3, 6> j;
            j << R * skew(point.now), -Eigen::Matrix3d::Identity();
            h += j.transpose() * point.information * j;
            b -= j.transpose() * point.information * r;
            ++m.inliers;
        }
        const Eigen::LLT<Matrix6> llt(h);
        if (2 * static_cast<std::size_t>(m.inliers) < body.size() || llt.info() != Eigen::Success) {
            return Status::kDegenerate;
        }
        const Vector6 d = llt.solve(b);
        if (!d.allFinite()) {
            return Status::kDegenerate;
        }
        m.q_Bi_Bj = (m.q_Bi_Bj * so3_exp(d.head<3>())).normalized();
        m.p_Bi_Bj += d.tail<3>();
        m.covariance = kCovarianceScale * llt.solve(Matrix6::Identity());
        rotation_sigma = std::min(rotation_sigma, 3.0 * std::sqrt(m.covariance.diagonal().head<3>().maxCoeff()));
    }
    out = m;
    return Status::kOk;
}

}  // namespace facet
