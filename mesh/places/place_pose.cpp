// SPDX-License-Identifier: BSD-2-Clause
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "mesh/places/place_pose.h"
#include "mesh/places/random_sequence.h"

namespace facet {
namespace {

constexpr int kHypotheses = 100;
/// Standard deviation of a point's place in one image (px): corners lie on whole pixels where they are detected, and
/// the two views have detected them apart.
constexpr double kPixelSigma = 1.0;
/// Hypotheses stand on two points and are further off than the pose that is refined on many.
constexpr double kLooseness = 3.0;
constexpr double kInlierGate = 11.3;  ///< 99 % of chi squared with three degrees of freedom
constexpr int kSteps = 8;
constexpr double kMinSpread_m = 0.2;  ///< horizontal distance of the two points of a hypothesis
/// Largest standard deviations of a pose that is of any use.
constexpr double kMaxYawSigma_rad = 0.02;
constexpr double kMaxPlaceSigma_m = 0.1;

/// The error of a match in the present camera, whitened, with its derivative.
class MatchErrors {
public:
    MatchErrors(const PlaceView& seen, const PlaceView& known, double focal_px)
        : seen_(seen.points.data(), seen.points.size()),
          known_(known.points.data(), known.points.size()),
          R_C_G_(seen.q_G_C.toRotationMatrix().transpose().cast<double>()),
          pixel_(kPixelSigma / focal_px) {}

    const PlacePoint& seen(const PointMatch& match) const { return seen_[match.seen]; }
    const PlacePoint& known(const PointMatch& match) const { return known_[match.known]; }

    /// The error [x y 1/z] and the inverse of its covariance. @param jacobian  by the pose; nullptr to skip
    /// @return false if the point is not in front of the camera
    bool evaluate(const PointMatch& match, const YawPose& T_K_G, Eigen::Vector3d& error, Eigen::Matrix3d& information,
                  Eigen::Matrix<double, 3, 4>* jacobian) const;

private:
    std::span<const PlacePoint> seen_;
    std::span<const PlacePoint> known_;
    Eigen::Matrix3d R_C_G_;
    double pixel_;
};

bool MatchErrors::evaluate(const PointMatch& match, const YawPose& T_K_G, Eigen::Vector3d& error,
                           Eigen::Matrix3d& information, Eigen::Matrix<double, 3, 4>* jacobian) const {
    const PlacePoint& now = seen(match);
    const PlacePoint& then = known(match);
    const Eigen::Matrix3d R_G_K = yaw_matrix(-T_K_G.yaw);
    const Eigen::Vector3d ray_K = then.p_G.cast<double>();
    const Eigen::Vector3d from = ray_K - T_K_G.p;
    const Eigen::Vector3d p_C = R_C_G_ * (R_G_K * from);
    const Eigen::Vector3d q_C = R_C_G_ * now.p_G.cast<double>();
    constexpr double kNear_m = 0.05;
    if (p_C.z() < kNear_m || q_C.z() < kNear_m) {
        return false;
    }
    const double rho = 1.0 / p_C.z();
    const double x = p_C.x() * rho;
    const double y = p_C.y() * rho;
    error = Eigen::Vector3d(x - q_C.x() / q_C.z(), y - q_C.y() / q_C.z(), rho - 1.0 / q_C.z());
    Eigen::Matrix3d d_d_p;  // by the point in the camera
    d_d_p << rho, 0.0, -x * rho, 0.0, rho, -y * rho, 0.0, 0.0, -rho * rho;
    const Eigen::Matrix3d d_d_K = d_d_p * R_C_G_ * R_G_K;

    // The known point's error: along its line of sight by its depth, across it by a pixel at its distance.
    const double distance = ray_K.norm();
    const Eigen::Vector3d along = d_d_K * ray_K * then.depth_sigma;
    const double across = pixel_ * distance;
    const double rho_sigma = now.depth_sigma / q_C.z();
    Eigen::Matrix3d covariance = along * along.transpose() + across * across * d_d_K * d_d_K.transpose();
    covariance(0, 0) += pixel_ * pixel_;
    covariance(1, 1) += pixel_ * pixel_;
    covariance(2, 2) += rho_sigma * rho_sigma;
    information = covariance.inverse();
    if (jacobian != nullptr) {
        const Eigen::Vector3d turned = R_G_K * from;
        jacobian->col(0) = d_d_p * (R_C_G_ * Eigen::Vector3d(turned.y(), -turned.x(), 0.0));
        jacobian->rightCols<3>() = -d_d_K;
    }
    return true;
}

/// Squared error of a match under a pose; beyond every gate behind the camera.
double chi2(const MatchErrors& errors, const PointMatch& match, const YawPose& pose) {
    Eigen::Vector3d error;
    Eigen::Matrix3d information;
    return errors.evaluate(match, pose, error, information, nullptr) ? error.dot(information * error) : 1e9;
}

int count_inliers(const MatchErrors& errors, const PointMatches& matches, const YawPose& pose, double gate) {
    return static_cast<int>(
        std::ranges::count_if(matches, [&](const PointMatch& m) { return chi2(errors, m, pose) < gate; }));
}

/// The pose that takes two points seen to the two known ones. @return false if they do not determine it
bool pose_of_two(const MatchErrors& errors, const PointMatch& a, const PointMatch& b, YawPose& pose) {
    const Eigen::Vector3d seen_a = errors.seen(a).p_G.cast<double>();
    const Eigen::Vector3d known_a = errors.known(a).p_G.cast<double>();
    const Eigen::Vector3d seen_b = errors.seen(b).p_G.cast<double>();
    const Eigen::Vector3d known_b = errors.known(b).p_G.cast<double>();
    const Eigen::Vector3d seen = seen_b - seen_a;
    const Eigen::Vector3d known = known_b - known_a;
    if (std::min(seen.head<2>().norm(), known.head<2>().norm()) < kMinSpread_m) {
        return false;
    }
    pose.yaw = wrapped(std::atan2(known.y(), known.x()) - std::atan2(seen.y(), seen.x()));
    pose.p = 0.5 * (known_a + known_b - pose.R() * (seen_a + seen_b));
    return true;
}

/// A Gauss-Newton step on all matches under a Cauchy loss. @return the normal matrix
YawPose::Covariance refine(const MatchErrors& errors, const PointMatches& matches, double gate, YawPose& pose) {
    YawPose::Covariance h = YawPose::Covariance::Zero();
    YawPose::Tangent b = YawPose::Tangent::Zero();
    for (const PointMatch& match : matches) {
        Eigen::Vector3d error;
        Eigen::Matrix3d information;
        Eigen::Matrix<double, 3, 4> j;
        if (!errors.evaluate(match, pose, error, information, &j)) {
            continue;
        }
        const double squared = error.dot(information * error);
        if (squared >= gate) {
            continue;
        }
        const double weight = 1.0 / (1.0 + squared / kInlierGate);
        h += weight * j.transpose() * information * j;
        b -= weight * j.transpose() * information * error;
    }
    h.diagonal().array() += 1e-9;
    pose = pose.box_plus(h.ldlt().solve(b));
    return h;
}

}  // namespace

Status find_pose(const PlaceView& seen, const PlaceView& known, const PointMatches& matches, double focal_px,
                 std::uint64_t seed, PlacePose& pose) {
    if (matches.size() < static_cast<std::size_t>(kMinInliers)) {
        return Status::kDegenerate;
    }
    const MatchErrors errors(seen, known, focal_px);
    const double loose = kInlierGate * kLooseness * kLooseness;
    RandomSequence random(seed);
    YawPose best;
    int most = 0;
    for (int i = 0; i < kHypotheses; ++i) {
        const PointMatch& a = matches[random.index(matches.size())];
        const PointMatch& b = matches[random.index(matches.size())];
        YawPose candidate;
        if (pose_of_two(errors, a, b, candidate)) {
            if (const int count = count_inliers(errors, matches, candidate, loose); count > most) {
                most = count;
                best = candidate;
            }
        }
    }
    if (most < kMinInliers) {
        return Status::kDegenerate;
    }
    YawPose::Covariance h;
    for (int step = 0; step < kSteps; ++step) {
        h = refine(errors, matches, step < kSteps / 2 ? loose : kInlierGate, best);
    }
    const int inliers = count_inliers(errors, matches, best, kInlierGate);
    const YawPose::Covariance covariance = h.inverse();
    const bool is_determined = covariance.allFinite() && covariance(0, 0) < kMaxYawSigma_rad * kMaxYawSigma_rad &&
                               covariance.diagonal().tail<3>().maxCoeff() < kMaxPlaceSigma_m * kMaxPlaceSigma_m;
    if (inliers < kMinInliers || inliers < kMinShare * static_cast<double>(matches.size()) || !is_determined) {
        return Status::kDegenerate;
    }
    pose = {best, covariance, static_cast<int>(matches.size()), inliers};
    return Status::kOk;
}

}  // namespace facet
