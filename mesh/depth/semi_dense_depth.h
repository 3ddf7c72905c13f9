// SPDX-License-Identifier: BSD-2-Clause
// Depth of a few thousand pixels of each keyframe, a slice of them at every frame.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "estimator/frontend/image_pyramid.h"
#include "estimator/geometry/stereo_rig.h"
#include "estimator/values/keyframe_view.h"
#include "mesh/capacity.h"
#include "mesh/depth/depth_matcher.h"
#include "mesh/depth_point.h"
#include "mesh/mesher.h"
#include "platform/base/fixed_vector.h"
#include "platform/base/image_view.h"

namespace facet {

/// What has been done since configure().
struct DepthCounters {
    std::uint64_t keyframes = 0;   ///< begun
    std::uint64_t unfinished = 0;  ///< of these: the next keyframe came first
    std::uint64_t untextured = 0;  ///< squares without a pixel to match
    std::array<std::uint64_t, static_cast<std::size_t>(DepthVerdict::kCount)> verdicts{};  ///< by DepthVerdict
    std::uint64_t lonely = 0;  ///< matched, but too few neighbours agree
    std::uint64_t points = 0;
};

/// The image is cut into squares. In each the pixel with the steepest gradient along its epipolar line is matched
/// (DepthMatcher), among depths that the mesher's triangulation of the keyframe suggests (Mesher::depth_prior) or,
/// where it says nothing, among all. Matches with which too few of the squares around them agree, within three standard
/// deviations and a pixel, are left out. The rest are points with their uncertainty along the ray, for the grid.
///
/// A keyframe begins with copies of its images; then each advance() looks at a fixed number of squares, spread over the
/// whole image. So the time of a frame is bounded, and if the next keyframe comes before the end, what there is covers
/// all of the view. Results depend on the order of calls alone. There are at most kMaxDepthPoints squares: those of
/// larger images are wider. About 0.5 MB and four times the size of the images. Heap: in configure() only.
/// Thread-bound.
class SemiDenseDepth {
public:
    static constexpr int kSquare_px = 14;
    static constexpr int kSquaresPerFrame = 500;

    /// @param square_px  side of a square
    /// @param per_frame  squares that an advance() looks at
    /// @return kInvalidArgument if the images are smaller than 16 pixels (nothing is matched until configure()
    ///         succeeds).
    Status configure(const StereoRig& rig, int square_px = kSquare_px, int per_frame = kSquaresPerFrame);

    /// Starts on a keyframe, after the mesher has taken it in; an unfinished one is dropped. Does nothing if an image
    /// is empty or the cameras are exchanged.
    void begin(const KeyframeView& view, const ImageView& left, const ImageView& right);

    /// Looks at the next squares. @param mesher  has taken in no other keyframe since begin()
    void advance(const Mesher& mesher);

    /// Whether there are squares to look at.
    bool is_busy() const { return next_ < squares_; }

    /// Whether take() has anything new: begun and not yet taken.
    bool has_begun() const { return has_begun_; }

    /// Ends the keyframe: points from the squares looked at so far. Valid until the next call.
    std::span<const DepthPoint> take();

    const DepthCounters& counters() const { return counters_; }

private:
    /// A square that has been looked at.
    struct Square {
        Eigen::Vector2f xy = Eigen::Vector2f::Zero();  ///< see DepthMatch
        float inverse_depth = 0.0F;                    ///< 0: not matched
        float sigma = 0.0F;
        float per_px = 0.0F;
    };

    void look_at(int square, const Mesher& mesher);
    bool find_pixel(int column, int row, const Eigen::Vector2f& direction, Eigen::Vector2d& uv,
                    Eigen::Vector2f& gradient) const;
    int agreeing(int column, int row) const;

    int per_frame_ = kSquaresPerFrame;
    DepthMatcher matcher_;
    ImagePyramid left_;
    ImagePyramid right_;
    int side_ = 0;  ///< of a square (px)
    int columns_ = 0;
    int rows_ = 0;
    int squares_ = 0;
    int stride_ = 1;  ///< between squares that follow each other, without a common divisor with their number
    int next_ = 0;
    bool has_begun_ = false;
    Se3 T_W_C0_;
    DepthCounters counters_;
    std::array<Square, kMaxDepthPoints> found_;
    std::array<Eigen::Vector2f, kMaxDepthPoints> directions_;  ///< of the epipolar lines in the squares' middles
    FixedVector<DepthPoint, kMaxDepthPoints> points_;
};

}  // namespace facet
