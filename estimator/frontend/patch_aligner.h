// SPDX-License-Identifier: BSD-2-Clause
// Aligns a stored image patch to an image with subpixel precision: inverse-compositional Lucas-Kanade.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "estimator/frontend/image_pyramid.h"
#include "estimator/frontend/patch_window.h"
#include "platform/base/status.h"

namespace facet {

/// Pose of a patch in an image: template offset x (px from the patch's anchor point) is seen at A * x + uv (level 0).
struct PatchPose {
    Eigen::Matrix2f A = Eigen::Matrix2f::Identity();
    Eigen::Vector2d uv = Eigen::Vector2d::Zero();  ///< position of the anchor point (px)
};

/// A patch around an anchor point, cut from levels of a pyramid and prepared for alignment. On every level it is cut on
/// whole pixels, as near to the anchor as these allow, so that its grey values are not interpolated; the remaining
/// offset is stored. Filled by PatchAligner.
struct PatchTemplate {
    /// A number for each unknown: [t, A row by row]. The steepest-descent images are j = [gu gv gu*x gu*y gv*x gv*y] at
    /// the offset (x, y) from the anchor.
    using Descent = Eigen::Matrix<float, 6, 1>;

    struct Level {
        bool valid = false;     ///< the patch with its gradients lay inside the image and has texture
        float contrast = 0.0F;  ///< weighted sum of squared grey values about their mean
        Eigen::Vector2f offset = Eigen::Vector2f::Zero();    ///< patch centre minus anchor (px of this level)
        Eigen::Matrix2f inverse2 = Eigen::Matrix2f::Zero();  ///< (J^T W J)^-1 of the position
        /// What P takes from the steepest-descent images j, J = P j = j - by_one - by_grey T. Beyond the position's two
        /// only on level 0.
        Descent by_one = Descent::Zero();
        Descent by_grey = Descent::Zero();
    };
    std::array<Level, ImagePyramid::kMaxLevels> levels;
    Eigen::Matrix<float, 6, 6> inverse6 = Eigen::Matrix<float, 6, 6>::Zero();  ///< (J^T W J)^-1 of level 0
    std::vector<float> planes;  ///< per level: W T, W gu, W gv, with the gradient (gu, gv)
};

/// What extract() is to prepare.
struct ExtractOptions {
    int coarsest = 2;     ///< levels 0 to this one
    bool affine = false;  ///< level 0 for affine alignment too
};

struct AlignOptions {
    int coarsest = 2;              ///< level to start at
    int finest = 0;                ///< level to end at
    bool affine = false;           ///< on level 0, estimate A too (requires extraction with affine); else keep it
    float min_correlation = 0.8F;  ///< least normalised correlation on the last level
    float enough_px = 0.0F;        ///< precision that suffices, if coarser than the aligner's own (px)
};

/// Lucas-Kanade alignment, inverse compositional [Baker04], of
///   I(A x + uv) = alpha T(x) + beta      for x in a Gaussian-weighted disk,
/// over uv (and A on request). Gain and offset are eliminated exactly: the steepest-descent images J are projected onto
/// the complement of {1, T}, so that J^T W I / alpha is the right hand side of the normal equations. The iteration
/// converges linearly. It ends when the step is below the epsilon or, if AlignOptions::enough_px is larger, when the
/// distance still to go, extrapolated from the rate of the last two steps, is below that.
/// Heap: in configure() and allocate() only. Thread-bound.
class PatchAligner {
public:
    /// A check against a threshold needs a precision of this share of the threshold.
    static constexpr float kCheckPrecision = 0.1F;

    /// @param window_px  side of the window, odd
    Status configure(int window_px, int levels, int max_iterations, double epsilon_px);

    /// Allocates a template's pixels for this aligner's window.
    void allocate(PatchTemplate& patch) const;

    /// Cuts a patch at uv. Levels on which the patch leaves the image are marked invalid.
    /// @return kNotFound if level 0 is among them; kDegenerate if level 0 has too little texture (outputs then void).
    Status extract(const ImagePyramid& image, const Eigen::Vector2d& uv, const ExtractOptions& options,
                   PatchTemplate& patch);

    /// Refines `pose` in `image`, coarse to fine.
    /// @param correlation  weighted normalised correlation on the last level
    /// @return kNotFound if the patch left the image; kDegenerate if it did not converge or correlates too little
    ///         (pose untouched in both cases).
    Status align(const PatchTemplate& patch, const ImagePyramid& image, const AlignOptions& options, PatchPose& pose,
                 float& correlation) const;

    /// Weighted normalised correlation of one level at a pose, -1 if outside.
    float correlate(const PatchTemplate& patch, const ImagePyramid& image, int level, const PatchPose& pose) const;

    int window_px() const { return window_.side(); }
    /// Distance to the border that a point must keep so that extract() succeeds on level 0 (px).
    double border_px() const { return window_.half() + 2.0; }

private:
    struct Found {
        Eigen::Vector2f at;
        Eigen::Matrix2f A;
        float correlation = 0.0F;
    };
    Status align_level(const PatchTemplate& patch, const RowPairs& image, int level, bool affine, float epsilon_px,
                       bool by_rate, Found& found) const;
    /// Gauss-Newton step. @param sums  of accumulate()
    bool step(const PatchTemplate& patch, const PatchTemplate::Level& level, bool affine, const float* sums,
              Found& found, float& length) const;
    template <bool kAffine>
    bool extract_level(const ImageView& image, const Eigen::Vector2d& at, PatchTemplate::Level& level, float* planes,
                       Eigen::Matrix<float, 6, 6>& inverse6);
    void cut(const ImageView& image, int u, int v);
    bool covers(const RowPairs& image, const Eigen::Vector2f& centre, const Eigen::Matrix2f& A) const;
    std::ptrdiff_t plane_offset(int level) const { return std::ptrdiff_t{3} * level * window_.count(); }
    const float* planes(const PatchTemplate& patch, int level) const {
        return patch.planes.data() + plane_offset(level);
    }

    int levels_ = 0;
    int max_iterations_ = 0;
    float epsilon_px_ = 0.0F;
    PatchWindow window_;
    std::vector<float> work_;  ///< grey values and gradients while extracting
};

}  // namespace facet
