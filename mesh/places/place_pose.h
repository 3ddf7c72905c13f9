// SPDX-License-Identifier: BSD-2-Clause
// Whether a view shows a place that is remembered, and from where.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "mesh/places/place.h"
#include "platform/base/status.h"

namespace facet {

/// A point of the present view and the one of the place that looks like it.
struct PointMatch {
    std::uint16_t seen = 0;
    std::uint16_t known = 0;
    std::uint16_t distance = 0;  ///< of their codes
};
using PointMatches = FixedVector<PointMatch, kMaxPlacePoints>;

/// Pairs of points that are each other's most similar one. Reentrant. No heap.
void match_points(std::span<const PlacePoint> seen, std::span<const PlacePoint> known, PointMatches& matches);

/// Whether matches may be of one place: some of them are closer than points of different places are. Of a view's
/// comparisons with all other places of a building it leaves one in six.
bool is_promising(const PointMatches& matches);

/// Where a view is, seen from a place.
struct PlacePose {
    YawPose T_K_G;  ///< of the view G in the place K
    YawPose::Covariance covariance = YawPose::Covariance::Zero();
    int matches = 0;
    int inliers = 0;
};

/// The pose on which most matches agree. Both frames have vertical z axes, so two matches determine it [Sweeney14]:
/// their horizontal distances give the turn. The best of kHypotheses such pairs is refined on its inliers
/// (SightingFit). Reentrant. Deterministic. No heap.
/// @param seed  of the choice of pairs
/// @return kDegenerate if fewer than kMinInliers matches agree, or less than kMinShare of all, or they leave the pose
///         undetermined (pose untouched)
Status find_pose(const PlaceView& seen, const PlaceView& known, const PointMatches& matches, double focal_px,
                 std::uint64_t seed, PlacePose& pose);

/// Four matches have twelve numbers and determine four: three times as many are asked for.
inline constexpr int kMinInliers = 12;
inline constexpr double kMinShare = 0.3;

}  // namespace facet
