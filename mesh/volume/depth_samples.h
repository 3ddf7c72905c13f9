// SPDX-License-Identifier: BSD-2-Clause
// Depth of a keyframe's pixels, by stereo and by the vehicle's motion.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "estimator/frontend/image_pyramid.h"
#include "estimator/geometry/stereo_rig.h"
#include "estimator/values/camera_corrections.h"
#include "mesh/depth/depth_matcher.h"
#include "mesh/mesher.h"

namespace facet {

/// One square of the image: its pixel that changes most along the epipolar line of the stereo pair, and that one's
/// depth.
struct DepthSample {
    Eigen::Vector2f uv = Eigen::Vector2f::Zero();        ///< left pixel
    Eigen::Vector2f gradient = Eigen::Vector2f::Zero();  ///< there (grey/px)
    Eigen::Vector2f xy = Eigen::Vector2f::Zero();        ///< normalised, undistorted, in C0
    float inverse_depth = 0.0F;                          ///< 1 / Z in C0 (1/m); 0: not known
    float sigma = 0.0F;                                  ///< its standard deviation (1/m)
    int confirmed = 0;                                   ///< other keyframes whose images agree,
    int contradicted = 0;                                ///< and that match it elsewhere
};

/// Measures an image in squares of `side_px`. The matcher is that of semi-dense depth, whose points are farther apart.
/// Heap. Thread-bound. Deterministic.
class DepthSampler {
public:
    DepthSampler(const StereoRig& rig, int side_px);

    int columns() const { return columns_; }
    int rows() const { return rows_; }
    int side_px() const { return side_; }
    /// Change of the inverse depth per pixel of disparity (1/m/px).
    double per_px() const { return stereo_.per_px(); }

    /// One sample for each square, row by row.
    /// @param mesher  has taken in this keyframe: between which depths to search; nullptr: at all
    std::vector<DepthSample> measure(const ImagePyramid& left, const ImagePyramid& right,
                                     const CameraCorrections& cameras, const Mesher* mesher);

    /// Looks for samples of one left image in another one that was taken from elsewhere, near the depth that is known.
    /// What agrees makes the sample more certain, by the variances; what is found elsewhere contradicts it.
    /// @param T_C_other  the other left camera, in this one
    void compare(const ImagePyramid& own, const ImagePyramid& other, const Se3& T_C_other,
                 const CameraCorrections& cameras, std::vector<DepthSample>& samples);

private:
    bool find_pixel(const ImageView& image, int square, DepthSample& sample) const;
    DepthRange range_of(const Mesher* mesher, const Eigen::Vector2d& xy) const;

    StereoRig rig_;
    DepthConfig config_;
    DepthMatcher stereo_;
    DepthMatcher motion_;
    int side_ = 0;
    int columns_ = 0;
    int rows_ = 0;
    std::vector<Eigen::Vector2f> directions_;  ///< of the epipolar lines in the squares' middles
};

}  // namespace facet
