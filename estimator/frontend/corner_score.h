// SPDX-License-Identifier: BSD-2-Clause
// How corner-like each pixel of an image is.
#pragma once

#include <cstdint>
#include <vector>

#include "platform/base/image_view.h"

namespace facet {

/// Least eigenvalue of the gradient matrix [Shi94]
///   M = sum over a 5x5 window of g g',   g = (Sobel 3x3 of the image) / (20 * 255)
/// Sums are exact integers: column sums slide down the image, so that the cost per pixel does not depend on the window.
/// Heap: in configure() only. Thread-bound.
class CornerScore {
public:
    static constexpr int kReach = 3;  ///< distance to the farthest pixel that a score depends on

    void configure(int width, int height);

    /// Scores of an image of the configured size (FACET_ASSERT); pixels nearer than kReach to the border stay 0.
    void compute(const ImageView& image);

    const float* row(int v) const { return scores_.data() + static_cast<std::ptrdiff_t>(v) * width_; }
    /// The image's greatest score.
    float best() const { return best_; }

private:
    static constexpr int kWindow = 5;

    void gradients(const ImageView& image, int v);
    void slide(int v);
    void finish_row(int v);

    int width_ = 0;
    int height_ = 0;
    float best_ = 0.0F;
    std::vector<std::int16_t> gu_;  ///< of the last kWindow + 1 rows
    std::vector<std::int16_t> gv_;
    std::vector<std::int32_t> uu_;  ///< sums over the last kWindow rows, one per column
    std::vector<std::int32_t> uv_;
    std::vector<std::int32_t> vv_;
    std::vector<float> scores_;
};

}  // namespace facet
