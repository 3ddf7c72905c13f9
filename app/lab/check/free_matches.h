// SPDX-License-Identifier: BSD-2-Clause
// Points found in pairs of images without any use of a calibration, so that they can judge it.
#pragma once

#include <cstdint>
#include <vector>

#include "estimator/frontend/detector.h"
#include "estimator/frontend/image_pyramid.h"
#include "estimator/frontend/patch_aligner.h"
#include "platform/base/image_view.h"
#include "platform/base/status.h"

namespace facet {

/// One point in two images (px).
struct PointPair {
    Eigen::Vector2d first = Eigen::Vector2d::Zero();
    Eigen::Vector2d second = Eigen::Vector2d::Zero();
};

/// Matches corners between images of one size. Thread-bound. Heap.
class FreeMatcher {
public:
    /// @return kInvalidArgument if the images are too small for three pyramid levels
    Status configure(int width, int height);

    /// Left and right image of a stereo pair: each corner's surroundings (36 px) are looked for by normalised
    /// correlation on level 2 over a third of the width and a sixth of the height to all sides; the best place must
    /// stand out, and is refined to level 0 and back.
    std::vector<PointPair> match_stereo(const ImageView& left, const ImageView& right);

    /// The same camera's images over time: corners of one image, the anchor, are followed by Lucas-Kanade from frame to
    /// frame, over three or four levels, and back. Call it frame by frame.
    /// @param starts_anew  this image is the next anchor, after its pairs have been found
    /// @return the corners that were followed up to here: in the anchor, and now; nothing at the first call
    std::vector<PointPair> follow(const ImageView& now, bool starts_anew);

private:
    /// Sums over a part of an image.
    struct GreySums {
        std::uint32_t grey = 0;
        std::uint32_t squares = 0;
    };

    void measure_energy(const ImageView& image);
    bool search(const Eigen::Vector2d& corner, const ImageView& left, const ImageView& right, Eigen::Vector2d& found);
    /// Refines `second` from its coarsest level and back again. @return whether both ways agree
    bool align_both_ways(const ImagePyramid& from, const ImagePyramid& to, int coarsest, PointPair& pair);

    int levels_ = 0;
    Detector detector_;
    PatchAligner aligner_;
    PatchTemplate patch_;
    PatchTemplate back_;
    ImagePyramid first_;
    ImagePyramid second_;
    std::vector<PointPair> followed_;
    std::vector<float> template_;
    std::vector<GreySums> integral_;  ///< of the right image's search level, over all that is above and left
    std::vector<float> energy_;       ///< of its places, by measure_energy()
};

/// Mean absolute difference of two images of one size (grey levels).
double mean_difference(const ImageView& a, const ImageView& b);

/// Mean of an image (grey levels).
double mean_grey(const ImageView& image);

}  // namespace facet
