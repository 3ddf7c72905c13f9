// SPDX-License-Identifier: BSD-2-Clause
// One mesh of a whole run, from the depth of its keyframes.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "estimator/values/keyframe_view.h"
#include "mesh/volume/bare_surfaces.h"
#include "mesh/volume/depth_samples.h"
#include "mesh/volume/surface_patches.h"
#include "mesh/volume/tsdf_volume.h"
#include "platform/base/image_view.h"

namespace facet {

/// Every keyframe, and between two of them every frame that shows something new, is measured when it comes: stereo at
/// one pixel of each square of four. When its keyframe leaves the window, and its pose is final, what other views saw
/// of the same surface makes its depths more certain or refutes them (DepthSampler), pieces of plane are laid through
/// those that agree (fit_patch), and over what is bare between them (BareSurfaces), and these go into a volume
/// with that pose (TsdfVolume), whose surface is the mesh. What was never near enough to tell its steps is left out.
/// About 1 MB a view; those of the window and kKeptAfter more are kept. Heap. Thread-bound. Deterministic.
class MeshFusion {
public:
    explicit MeshFusion(const StereoRig& rig);

    /// A keyframe.
    /// @param mesher  has taken it in
    /// @param resets  how often the estimator has restarted: what it said before and after does not belong together
    void add(const KeyframeView& view, std::uint32_t resets, const ImageView& left, const ImageView& right,
             const Mesher& mesher);

    /// A frame between keyframes: taken in if it shows enough that the view before it did not. Its pose moves with the
    /// newest keyframe's.
    /// @param T_W_C0  as estimated since that keyframe
    void add_between(const Se3& T_W_C0, std::uint32_t resets, const ImageView& left, const ImageView& right);

    /// The keyframes still in the window leave, and the mesh is written. Throws InputError if that fails.
    void write(const std::string& path);

private:
    /// A keyframe, or a frame between two.
    struct View {
        Timestamp keyframe;  ///< itself, or the one before it,
        Se3 T_K_C0;          ///< in which it stands here
        Se3 T_W_C0;
        std::uint32_t resets = 0;
        CameraCorrections cameras;
        ImagePyramid left;
        std::vector<DepthSample> samples;
        bool has_left = false;  ///< the window
    };
    void take(View view, const ImageView& left, const ImageView& right, const Mesher* mesher);
    void leave(std::size_t index);
    void compare(std::size_t index);

    DepthSampler sampler_;
    SquareLayout layout_;
    SquareRaster raster_;
    BareSurfaces bare_;
    TsdfVolume volume_;
    ImagePyramid right_;
    std::deque<std::unique_ptr<View>> views_;  ///< oldest first
    Se3 T_W_K_;                                ///< the newest keyframe, as its view had it,
    bool has_K_ = false;                       ///< and whether it was taken
};

}  // namespace facet
