// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/planes/plane_memory.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "platform/base/angle.h"

namespace facet {
namespace {

constexpr double kSame = 11.3;     // chi-square of three degrees of freedom: 1 % of equal planes are above
constexpr double kOther = 30.0;    // a second plane below this might be meant as well
constexpr double kFloor_m = 0.01;  // surfaces are not flat: what two parts of one differ by (1 sigma)
constexpr double kFloor_rad = 0.4 * kRadPerDeg;  // likewise
constexpr double kMaxTurn_rad = 20.0 * kRadPerDeg;
constexpr double kThere = 0.5;  // of the smaller surface: two planes are not in the same place

/// What a covariance has gained: no direction less than nothing.
Eigen::Matrix2d gain(const Eigen::Matrix2d& now, const Eigen::Matrix2d& then) {
    const Eigen::Matrix2d difference = now - then;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(difference);
    return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() * eigen.eigenvectors().transpose();
}

/// Height of the plane above `at`'s centroid, and its slopes along `at`'s axes, by its own uncertainty.
Eigen::Matrix3d covariance_at(const PlaneFit& plane, const PlaneFit& at) {
    const Eigen::Vector3d arm = at.centroid_W - plane.centroid_W;
    Eigen::Matrix3d d;  // by height, slope along, slope across
    d << 1.0, plane.along_W.dot(arm), plane.across_W.dot(arm), 0.0, plane.along_W.dot(at.along_W),
        plane.across_W.dot(at.along_W), 0.0, plane.along_W.dot(at.across_W), plane.across_W.dot(at.across_W);
    const Eigen::Vector3d sigma(plane.sigma_m, plane.sigma_along_rad, plane.sigma_across_rad);
    return d * sigma.cwiseAbs2().asDiagonal() * d.transpose();
}

/// Standard deviation of the drift between two sightings, across all directions (m).
double drift_along(const SeenPlane& then, const SeenPlane& now) {
    double variance = 0.0;
    for (int k = 0; k < 3; ++k) {
        const Eigen::Vector3d axis = Eigen::Vector3d::Unit(k);
        variance +=
            gain(now.from.effect_at(now.fit.centroid_W, axis), then.from.effect_at(now.fit.centroid_W, axis))(0, 0);
    }
    return std::sqrt(variance);
}

}  // namespace

/// The plane is fixed to the vehicle's view of the world, which is off by a turn e_0 about the vertical through its
/// place, and by a shift e_1..3.
Eigen::Matrix2d SightedFrom::effect_at(const Eigen::Vector3d& c_W, const Eigen::Vector3d& normal_W) const {
    Eigen::Matrix<double, 2, 4> d = Eigen::Matrix<double, 2, 4>::Zero();
    d(0, 0) = normal_W.dot(Eigen::Vector3d::UnitZ().cross(c_W - p_W));
    d.block<1, 3>(0, 1) = normal_W.transpose();
    d(1, 0) = 1.0;
    return d * covariance * d.transpose();
}

double PlaneMemory::distance(const SeenPlane& then, const SeenPlane& now) {
    constexpr double kNever = std::numeric_limits<double>::infinity();
    const PlaneFit& a = then.fit;
    const PlaneFit& b = now.fit;
    const double cosine = a.normal_W.dot(b.normal_W);
    if (!may_be_one(then.kind, now.kind) || !(cosine > std::cos(kMaxTurn_rad))) {
        return kNever;
    }
    const Eigen::Matrix2d drift =
        gain(now.from.effect_at(b.centroid_W, b.normal_W), then.from.effect_at(b.centroid_W, b.normal_W));
    if (then.reach.distance(now.reach) > PlaneReach::kBeside_m + 3.0 * drift_along(then, now)) {
        return kNever;
    }
    // Of the plane now above the plane then, at the centroid now; a turn psi about the vertical lowers what is along
    // the level direction z x n.
    const Eigen::Vector3d level = Eigen::Vector3d::UnitZ().cross(b.normal_W);
    Eigen::Matrix<double, 3, 2> d = Eigen::Matrix<double, 3, 2>::Zero();
    d(0, 0) = 1.0;
    d(1, 1) = -level.dot(b.along_W);
    d(2, 1) = -level.dot(b.across_W);
    Eigen::Matrix3d covariance = d * drift * d.transpose() + covariance_at(a, b) + covariance_at(b, b);
    covariance.diagonal() += Eigen::Vector3d(kFloor_m * kFloor_m, kFloor_rad * kFloor_rad, kFloor_rad * kFloor_rad);
    const Eigen::Vector3d difference(a.residual(b.centroid_W), a.normal_W.dot(b.along_W) / cosine,
                                     a.normal_W.dot(b.across_W) / cosine);
    const Eigen::LLT<Eigen::Matrix3d> llt(covariance);
    const double chi2 = llt.info() == Eigen::Success ? difference.dot(llt.solve(difference)) : kNever;
    return std::isfinite(chi2) ? chi2 : kNever;
}

void PlaneMemory::keep(const SeenPlane& plane) {
    forget(plane.id);
    if (planes_.full()) {
        planes_.erase_at(0);
    }
    planes_.push_back(plane);
}

void PlaneMemory::forget(PlaneId id) {
    for (std::size_t i = 0; i < planes_.size(); ++i) {
        if (planes_[i].id == id) {
            planes_.erase_at(i);
            return;
        }
    }
}

Status PlaneMemory::recall(const SeenPlane& seen, bool only_there, SeenPlane& out) {
    struct Found {
        double distance = std::numeric_limits<double>::infinity();
        double second = std::numeric_limits<double>::infinity();
        std::size_t at = 0;
    };
    Found anywhere;
    Found there;
    for (std::size_t i = 0; i < planes_.size(); ++i) {
        const double d = distance(planes_[i], seen);
        for (Found* found : {&anywhere, &there}) {
            if (found == &there && planes_[i].reach.overlap(seen.reach) < kThere) {
                continue;
            }
            found->second = std::min(found->second, std::max(d, found->distance));
            if (d < found->distance) {
                found->distance = d;
                found->at = i;
            }
        }
    }
    const Found& found = only_there || there.distance < kSame ? there : anywhere;
    if (!(found.distance < kSame) || found.second < kOther) {
        return Status::kNotFound;
    }
    out = planes_[found.at];
    planes_.erase_at(found.at);
    return Status::kOk;
}

Status PlaneMemory::recall(const SeenPlane& seen, SeenPlane& out) { return recall(seen, false, out); }

Status PlaneMemory::recall_there(const SeenPlane& seen, SeenPlane& out) { return recall(seen, true, out); }

}  // namespace facet
