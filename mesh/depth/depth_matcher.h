// SPDX-License-Identifier: BSD-2-Clause
// Depth of one pixel of the left image, from the right one.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

#include "estimator/frontend/epipolar_geometry.h"
#include "estimator/frontend/epipolar_scan.h"
#include "estimator/frontend/row_pairs.h"

namespace facet {

class Mesher;

/// What became of a pixel that was to be matched.
enum class DepthVerdict : std::uint8_t {
    kMatched,
    kOutside,    ///< its curve is not in the right image, or the best place is at an end of what was searched
    kWeak,       ///< nothing correlates: occluded, without texture, or elsewhere
    kAmbiguous,  ///< another place is nearly as good: repeated texture, or an edge along the epipolar line
    kOneSided,   ///< the way back leads elsewhere: occluded
    kCount
};

/// Whether a match is also looked for the other way round: not needed where the depth was known before.
enum class DepthCheck : std::uint8_t { kBothWays, kOneWay };

/// Depths to search, as inverse depths 1 / Z in C0 (1/m).
struct DepthRange {
    double farthest = 0.0;
    double nearest = 0.0;
};

struct DepthMatch {
    Eigen::Vector2d xy = Eigen::Vector2d::Zero();  ///< normalised, undistorted by the lens as it is known now, in C0
    double inverse_depth = 0.0;                    ///< 1 / Z in C0 (1/m)
    double sigma = 0.0;                            ///< standard deviation of the inverse depth (1/m)
    double per_px = 0.0;                           ///< change of the inverse depth along the curve (1/m/px)
    float correlation = 0.0F;
};

/// Correlates a window about the pixel with places a pixel apart on its epipolar curve, under the calibration as it is
/// known now and in the distorted images (EpipolarScan). The best place must correlate well, stand out from any other
/// one, and lead back to the pixel. A parabola through it and its neighbours gives its fraction, and
///   sigma^2 = 2 (1 - s) / (n c) + 0.1^2 + (0.25 |g_across / g_along|)^2   (px^2)
/// with the correlation s, the effective number n of pixels in the window, and the curvature c of the correlation:
/// 2 (1 - s) / c is the variance of the two windows' difference over that of the window's gradient along the curve.
/// 0.1 px stand for interpolation, 0.25 px for how far the curve passes beside the true place, which moves the match
/// the more, the more the texture runs along the curve. Heap: in configure() only. Thread-bound. Deterministic.
class DepthMatcher {
public:
    static constexpr int kMaxPlaces = 4 * CurveStretch::kMaxPlaces;
    /// The window that is compared reaches this far from the pixel to every side (px).
    static constexpr int kReach_px = 4;

    void configure(const StereoRig& rig);
    /// Other cameras, or elsewhere; the calibration is forgotten. No heap.
    void set_rig(const StereoRig& rig);
    /// The calibration as it is known now; configure() forgets it.
    void correct(const CameraCorrections& corrections);

    /// Unit vector in which a left pixel moves when its match comes a pixel nearer, or zero where the rays of the
    /// lenses do not allow any.
    Eigen::Vector2f epipolar_direction(const Eigen::Vector2d& left_uv) const;

    using Ray = EpipolarGeometry::Ray;
    /// The ray of a left pixel, and where it is on the undistorted plane. @return kDegenerate: see EpipolarGeometry.
    Status ray_of(const Eigen::Vector2d& left_uv, Ray& ray, Eigen::Vector2d& xy) const;
    /// What to search along a ray: the depths of the corners of the triangle that it passes and some pixels beyond, or
    /// all where the triangulation says nothing. @param min_depth_m  nothing nearer
    DepthRange range_about(const Mesher& mesher, const Eigen::Vector2d& xy, double min_depth_m) const;
    /// @param gradient  of the left image at the pixel (grey/px)
    /// @param match     untouched unless matched
    DepthVerdict match(const RowPairs& left, const RowPairs& right, const Ray& ray, const Eigen::Vector2f& gradient,
                       const DepthRange& range, DepthMatch& match, DepthCheck check = DepthCheck::kBothWays);

    /// Change of the inverse depth per pixel at infinity in the middle of the image (1/m/px).
    double per_px() const { return per_px_; }

private:
    struct Place {
        Eigen::Vector2d uv;
        Eigen::Matrix2f A;
    };
    bool place(const Ray& ray, double inverse_depth, Place& place) const {
        return ok(geometry_.point_at(ray, inverse_depth, place.uv, place.A));
    }
    bool score(const RowPairs& left, const RowPairs& right, const Ray& ray, double first, double step, int places,
               Place begin);
    bool is_unique(std::span<const float> scores, int best) const;
    bool leads_back(const RowPairs& left, const RowPairs& right, const Ray& ray, const Place& found,
                    const Eigen::Vector2f& along);

    EpipolarGeometry geometry_;
    LensCorrection left_lens_ = LensCorrection::Zero();
    EpipolarScan scan_;
    double pixels_ = 1.0;  ///< effective number of pixels in the window
    double per_px_ = 0.0;
    std::array<float, kMaxPlaces> scores_{};
    std::array<float, CurveStretch::kMaxPlaces> back_{};
};

}  // namespace facet
