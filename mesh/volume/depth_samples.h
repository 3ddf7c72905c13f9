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
/// Heap in the constructor only. Thread-bound. Deterministic.
class DepthSampler {
public:
    DepthSampler(const StereoRig& rig, int side_px);

    int columns() const { return columns_; }
    int rows() const { return rows_; }
    int count() const { return columns_ * rows_; }
    int side_px() const { return side_; }
    /// Change of the inverse depth per pixel of disparity (1/m/px).
    double per_px() const { return stereo_.per_px(); }

    /// The calibration from now on.
    void correct(const CameraCorrections& cameras);
    /// The sample of a square, counted row by row.
    /// @param mesher  has taken in this keyframe: between which depths to search; nullptr: at all
    DepthSample measure(int square, const ImagePyramid& left, const ImagePyramid& right, const Mesher* mesher);

    /// The pixel of a square: `uv` and `gradient`, which is not zero. @return false: it has no texture (sample
    /// as it was)
    bool find_pixel(int square, const ImagePyramid& left, DepthSample& sample) const;
    /// Looks for the depth of such a sample, and where it is on the undistorted plane. @return whether there is one
    /// (sample as it was if not)
    bool match(const ImagePyramid& left, const ImagePyramid& right, const DepthRange& range, DepthSample& sample);
    /// From infinity to the nearest that is looked for.
    static DepthRange all_depths() { return {0.0, 1.0 / kMinDepth_m}; }

    /// The view to compare with from now on. @param T_C_other  its left camera, in the samples' one
    void face(const Se3& T_C_other, const CameraCorrections& cameras);
    /// Looks for a sample of one left image in another one that was taken from elsewhere, near the depth that is known.
    /// What agrees makes the sample more certain, by the variances; what is found elsewhere contradicts it.
    void compare(const ImagePyramid& own, const ImagePyramid& other, DepthSample& sample);

private:
    static constexpr double kMinDepth_m = 0.4;

    StereoRig rig_;
    DepthMatcher stereo_;
    DepthMatcher motion_;
    int side_ = 0;
    int columns_ = 0;
    int rows_ = 0;
    std::vector<Eigen::Vector2f> directions_;         ///< of the epipolar lines in the squares' middles
    Eigen::Vector3d base_ = Eigen::Vector3d::Zero();  ///< of the other camera that is compared with
};

}  // namespace facet
