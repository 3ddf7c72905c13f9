// SPDX-License-Identifier: BSD-2-Clause
// Finds corners, spread evenly over the image.
#pragma once

#include <Eigen/Core>
#include <boost/container/static_vector.hpp>
#include <cstdint>
#include <span>
#include <vector>

#include "estimator/frontend/corner_score.h"
#include "estimator/frontend/frontend_config.h"
#include "estimator/frontend/pixel_mask.h"
#include "estimator/geometry/camera_model.h"
#include "estimator/values/capacity.h"
#include "platform/base/image_view.h"

namespace facet {

using CornerList = boost::container::static_vector<Eigen::Vector2d, kMaxFeatures + kMaxSurfacePoints>;

/// Shi-Tomasi corners (least eigenvalue of the gradient matrix, [Shi94]) that are local maxima. The image is divided
/// into cells; cells with the fewest tracks are served first, with one corner per cell in each round. Corners lie on
/// whole pixels: a track follows the patch around its corner, so moving the corner by a fraction of a pixel would not
/// make it more accurate, and a patch cut on whole pixels needs no interpolation.
/// Heap: in configure() only. Thread-bound.
class Detector {
public:
    /// @param border_px  corners keep this distance to the border of the image and of the lens's circle
    void configure(const FrontendConfig& config, const CameraModel& camera, double border_px);

    /// Appends at most `wanted` corners of `image`, no nearer than min_distance_px to `occupied` and to each other, and
    /// not where the mask, of the image's size, covers it at this time.
    void detect(const ImageView& image, std::span<const Eigen::Vector2d> occupied, int wanted, CornerList& corners,
                const PixelMask* mask = nullptr, Timestamp now = {});

private:
    struct Candidate {
        float score = 0.0F;
        std::int16_t u = 0;
        std::int16_t v = 0;
    };
    static constexpr int kPerCell = 64;  ///< strongest candidates kept per cell: bounds the work

    void collect(float threshold);
    /// Offers those of the pixels (u ... u + count - 1, v), count <= simd::kLanes, that are free local maxima.
    void offer_peaks(int u, int v, int count, float threshold);
    void offer(int u, int v, float score);
    /// Next candidate of a cell that is not blocked; nullptr if none is left.
    const Candidate* next_free(std::size_t cell);
    void occupy(const Eigen::Vector2d& uv);
    int cell_of(int u, int v) const;

    FrontendConfig config_;
    int width_ = 0;
    int height_ = 0;
    CornerScore score_;
    std::vector<std::uint8_t> blocked_;
    std::vector<int> begin_;             ///< first pixel of each row where corners are requested
    std::vector<int> end_;               ///< and the one after the last
    std::vector<int> column_of_;         ///< column of cells that holds a pixel's column
    std::vector<int> row_of_;            ///< likewise
    std::vector<int> disc_;              ///< half width of the blocked disk, one entry per row
    std::vector<Candidate> candidates_;  ///< kPerCell per cell, strongest first
    std::vector<int> count_;             ///< candidates of each cell
    std::vector<int> next_;              ///< first candidate not yet examined
    std::vector<int> tracks_;            ///< tracks and new corners in each cell
    std::vector<int> order_;             ///< cells, emptiest first
};

}  // namespace facet
