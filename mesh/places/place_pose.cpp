// SPDX-License-Identifier: BSD-2-Clause
#include <algorithm>
#include <cmath>

#include "mesh/places/place_pose.h"
#include "mesh/places/random_sequence.h"
#include "mesh/places/sighting_fit.h"

namespace facet {
namespace {

constexpr int kHypotheses = 100;
/// Standard deviation of a point's place in one image (px): corners lie on whole pixels where they are detected, and
/// the two views have detected them apart.
constexpr double kPixelSigma = 1.0;
/// Of the squared error: hypotheses stand on two points and are further off than the pose that is refined on many.
constexpr double kLooseness = 9.0;
constexpr int kSteps = 8;
constexpr double kMinSpread_m = 0.2;  ///< horizontal distance of the two points of a hypothesis
/// Largest standard deviations of a pose that is of any use.
constexpr double kMaxYawSigma_rad = 0.02;
constexpr double kMaxPlaceSigma_m = 0.1;

/// The pose that takes two points seen to the two known ones. @return false if they do not determine it
bool pose_of_two(const Eigen::Vector3d& seen_a, const Eigen::Vector3d& known_a, const Eigen::Vector3d& seen_b,
                 const Eigen::Vector3d& known_b, YawPose& pose) {
    const Eigen::Vector3d seen = seen_b - seen_a;
    const Eigen::Vector3d known = known_b - known_a;
    if (std::min(seen.head<2>().norm(), known.head<2>().norm()) < kMinSpread_m) {
        return false;
    }
    pose.yaw = wrapped(std::atan2(known.y(), known.x()) - std::atan2(seen.y(), seen.x()));
    pose.p = 0.5 * (known_a + known_b - pose.R() * (seen_a + seen_b));
    return true;
}

}  // namespace

Status find_pose(const PlaceView& seen, const PlaceView& known, const PointMatches& matches, double focal_px,
                 std::uint64_t seed, PlacePose& pose) {
    if (matches.size() < static_cast<std::size_t>(kMinInliers)) {
        return Status::kDegenerate;
    }
    SightingFit fit(seen, known, kPixelSigma / focal_px);
    for (const PointMatch& match : matches) {
        fit.add(match.known, fit.direction_of(match.seen), match.seen);
    }
    RandomSequence random(seed);
    SightingFit::State best;
    int most = 0;
    for (int i = 0; i < kHypotheses; ++i) {
        const PointMatch& a = matches[random.index(matches.size())];
        const PointMatch& b = matches[random.index(matches.size())];
        SightingFit::State candidate;
        if (pose_of_two(seen.points[a.seen].p_G.cast<double>(), known.points[a.known].p_G.cast<double>(),
                        seen.points[b.seen].p_G.cast<double>(), known.points[b.known].p_G.cast<double>(),
                        candidate.T_K_G)) {
            if (const int count = fit.count_inliers(candidate, kLooseness); count > most) {
                most = count;
                best = candidate;
            }
        }
    }
    if (most < kMinInliers) {
        return Status::kDegenerate;
    }
    YawPose::Covariance covariance;
    for (int step = 0; step < kSteps; ++step) {
        covariance = fit.step(step < kSteps / 2 ? kLooseness : 1.0, best).covariance;
    }
    const int inliers = fit.count_inliers(best, 1.0);
    const bool is_determined = covariance.allFinite() && covariance(0, 0) < kMaxYawSigma_rad * kMaxYawSigma_rad &&
                               covariance.diagonal().tail<3>().maxCoeff() < kMaxPlaceSigma_m * kMaxPlaceSigma_m;
    if (inliers < kMinInliers || inliers < kMinShare * static_cast<double>(matches.size()) || !is_determined) {
        return Status::kDegenerate;
    }
    pose = {best.T_K_G, covariance, static_cast<int>(matches.size()), inliers};
    return Status::kOk;
}

}  // namespace facet
