// SPDX-License-Identifier: BSD-2-Clause
// Binary descriptors of points whose distance is known, upright by gravity.
#pragma once

#include <Eigen/Core>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include "estimator/frontend/image_pyramid.h"
#include "estimator/geometry/camera_model.h"
#include "platform/base/status.h"

namespace facet {

/// 256 comparisons of brightness in a patch [Calonder10].
using BinaryCode = std::array<std::uint64_t, 4>;

/// Number of comparisons that came out differently.
inline int distance(const BinaryCode& a, const BinaryCode& b) {
    return std::popcount(a[0] ^ b[0]) + std::popcount(a[1] ^ b[1]) + std::popcount(a[2] ^ b[2]) +
           std::popcount(a[3] ^ b[3]);
}

/// A point's surroundings in two sizes: squares of 2^octave and of twice as many sixteenths of a metre. Because sizes
/// are in metres, not pixels, views of a point from distances up to a factor of two apart have one of them in common.
struct PointCode {
    static constexpr int kIncomparable = 257;
    static constexpr int kMinOctave = -4;  ///< 4 mm: never smaller in an image whose depth is above 0.2 m
    static constexpr int kMaxOctave = 8;   ///< 16 m: far more than indoors

    BinaryCode fine{};
    BinaryCode coarse{};
    std::int8_t octave = 0;  ///< of the fine one

    /// Share of the comparisons that differ, out of 256; kIncomparable if no size is common.
    int distance_to(const PointCode& o) const {
        switch (octave - o.octave) {
            case 0: return (distance(fine, o.fine) + distance(coarse, o.coarse)) / 2;
            case 1: return distance(fine, o.coarse);
            case -1: return distance(coarse, o.fine);
            default: return kIncomparable;
        }
    }
};

/// How a point looks, upright and at the scale of its fine code, to be found again to a fraction of a pixel.
using UprightPatch = std::array<std::uint8_t, 144>;
inline constexpr int kPatchSide = 12;  ///< samples of an UprightPatch along each side

/// A square in an image, its downward side where gravity projects to, and of a size in metres.
struct UprightSquare {
    Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< (px)
    Eigen::Vector2d down = Eigen::Vector2d::Zero();    ///< unit vector
    double unit_px = 0.0;                              ///< half the side of a square of octave 0

    /// Half the side of the fine square (px).
    double half_px(int octave) const { return std::ldexp(unit_px, octave); }
    /// The octave whose square has between 16 and 32 pixels along a side.
    int fine_octave() const;
};

/// @param p_C     the point (m)
/// @param down_C  unit vector along gravity
/// @return kDegenerate if the point is behind the camera, or within 15 degrees of the vertical through it, where down
///         has no direction in the image
Status upright_square(const CameraModel& camera, const Eigen::Vector3d& p_C, const Eigen::Vector3d& down_C,
                      UprightSquare& square);

/// Codes and patch of a point. The squares of the codes are sampled at 32 x 32 points, smoothed, and compared at 256
/// pairs of points, close to the centre more often than far from it. Reentrant. No heap.
/// @param pyramid  kPlaceLevels or more
/// @return kNotFound if the larger square leaves the image; kDegenerate if the octave is out of range
Status describe(const ImagePyramid& pyramid, const UprightSquare& square, PointCode& code, UprightPatch& patch);

/// Levels of the pyramid that places are described and found in.
inline constexpr int kPlaceLevels = 3;

/// Samples in the square's frame, from the level of the pyramid whose pixels are nearest to their distance.
struct SquareSampler {
    const ImageView* image = nullptr;
    Eigen::Vector2f centre = Eigen::Vector2f::Zero();  ///< px of the level
    Eigen::Vector2f right = Eigen::Vector2f::Zero();   ///< from a sample to the next in its row (px)
    Eigen::Vector2f down = Eigen::Vector2f::Zero();    ///< from a row to the next (px)

    /// @param step_px  distance of samples at level 0
    SquareSampler(const ImagePyramid& pyramid, const UprightSquare& square, double step_px);
    /// Whether all samples of a square of this side lie in the image, shifted by this many samples right and down.
    bool covers(int side, const Eigen::Vector2f& shift = Eigen::Vector2f::Zero()) const;
};

}  // namespace facet
