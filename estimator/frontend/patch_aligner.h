// SPDX-License-Identifier: BSD-2-Clause
// Aligns a stored image patch with an image to a small fraction of a pixel: inverse-compositional Lucas-Kanade.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "estimator/frontend/image_pyramid.h"
#include "platform/base/status.h"

namespace facet {

/// Where a patch lies in an image: template offset x (px from the patch's anchor point) is seen at A * x + uv (level 0).
struct PatchPose {
    Eigen::Matrix2f A = Eigen::Matrix2f::Identity();
    Eigen::Vector2d uv = Eigen::Vector2d::Zero();  ///< position of the anchor point (px)
};

/// A patch around an anchor point, cut from each level of a pyramid. On every level it is cut on whole pixels, as near
/// to the anchor as they are, so that its grey values are not interpolated; the remaining offset is kept.
struct PatchTemplate {
    struct Level {
        bool valid = false;  ///< the patch with its gradients lay inside the image
        Eigen::Vector2f offset = Eigen::Vector2f::Zero();  ///< patch centre minus anchor (px of this level)
        float contrast = 0.0F;                             ///< weighted sum of squared grey values about their mean
        Eigen::Matrix<float, 6, 6> normal = Eigen::Matrix<float, 6, 6>::Zero();  ///< J^T J, order [t, A row by row]
    };
    std::array<Level, ImagePyramid::kMaxLevels> levels;
    std::vector<float> pixels;  ///< per level: grey value about the mean, d/du, d/dv, window^2 each
};

struct AlignOptions {
    int coarsest = 2;           ///< level to start at
    int finest = 0;             ///< level to end at
    bool affine = false;        ///< estimate A on level 0 as well; else keep it
    float min_correlation = 0.8F;  ///< least normalised correlation on the last level
};

/// Lucas-Kanade alignment, inverse compositional [Baker04], of
///   I(A x + uv) = alpha T(x) + beta      for x in a Gaussian-weighted square window,
/// over uv (and A on request). Gain and offset are eliminated exactly: the residual and the steepest-descent images are
/// projected onto the complement of {1, T}. Fixed storage after configure(); no heap, no exceptions. Thread-bound.
class PatchAligner {
public:
    /// @param window_px  side of the window, odd
    Status configure(int window_px, int levels, int max_iterations, double epsilon_px);

    /// Allocates a template's pixels for this aligner's window.
    void allocate(PatchTemplate& patch) const;

    /// Cuts a patch at uv. Levels on which the patch leaves the image are marked invalid.
    /// @return kNotFound if level 0 is among them; kDegenerate if level 0 has too little texture (outputs then void).
    Status extract(const ImagePyramid& image, const Eigen::Vector2d& uv, PatchTemplate& patch) const;

    /// Refines `pose` in `image`, coarse to fine.
    /// @param correlation  weighted normalised correlation on the last level
    /// @return kNotFound if the patch left the image; kDegenerate if it did not converge or correlates too little
    ///         (pose untouched in both cases).
    Status align(const PatchTemplate& patch, const ImagePyramid& image, const AlignOptions& options, PatchPose& pose,
                 float& correlation);

    /// Weighted normalised correlation of one level at a pose, -1 if outside.
    float correlate(const PatchTemplate& patch, const ImagePyramid& image, int level, const PatchPose& pose);

    int window_px() const { return window_; }
    /// Distance to the border a point must keep so that extract() succeeds on level 0 (px).
    double border_px() const { return window_ / 2 + 2.0; }

private:
    Status align_level(const PatchTemplate& patch, const ImageView& image, int level, bool affine, PatchPose& pose,
                       float& correlation);
    bool sample(const ImageView& image, const Eigen::Vector2f& centre, const Eigen::Matrix2f& A, float* out) const;
    const float* pixels(const PatchTemplate& patch, int level, int plane) const {
        return patch.pixels.data() + static_cast<std::ptrdiff_t>((level * 3 + plane) * area_);
    }

    int window_ = 0;
    int area_ = 0;
    int levels_ = 0;
    int max_iterations_ = 0;
    float epsilon_px_ = 0.0F;
    Eigen::ArrayXf weights_;  ///< window^2, sums to window^2
    Eigen::ArrayXf grid_x_;   ///< window^2, column offsets from the centre
    Eigen::ArrayXf grid_y_;
    Eigen::ArrayXf sampled_;  ///< workspace
    Eigen::ArrayXf residual_;
};

}  // namespace facet
