// SPDX-License-Identifier: BSD-2-Clause
// Correlates a patch of one image with a piece of a curve in another.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "estimator/frontend/patch_window.h"
#include "estimator/frontend/row_pairs.h"

namespace facet {

/// A short piece of the curve on which a point of the first image may be seen in the second one.
struct CurveStretch {
    static constexpr int kMaxPlaces = 32;

    Eigen::Vector2f first;   ///< place 0 (px)
    Eigen::Vector2f middle;  ///< place count / 2
    Eigen::Vector2f last;    ///< place count, the first one of the next stretch
    Eigen::Matrix2f A;       ///< derivative of the place in the middle with respect to the point in the first image
    int count = 0;           ///< number of places, at most kMaxPlaces
};

/// Neighbouring places on a curve see nearly the same pixels. Therefore the second image is interpolated once, in a
/// strip along the stretch: column j is centred on place j, rows run across. The patch is cut from the first image as
/// the strip would show it, rotated and scaled by A; the correlation then slides it over the columns, a vector of
/// places at a time, without interpolation. The places lie on the parabola through the three given points, and the
/// scale is that of the middle: accurate enough to find the best place, not to refine it.
/// Heap: in configure() only. Thread-bound.
class EpipolarScan {
public:
    /// @param window_px  side of the window, odd
    void configure(int window_px);

    /// Whether the places are about a pixel apart, as the scan's grid requires.
    static bool suits(const CurveStretch& stretch);

    /// Weighted normalised correlation of the patch about `at` with each place; -1 where the patch would leave the
    /// second image, and everywhere if the patch or the place has no texture. The stretch must be one that suits().
    void correlate(const RowPairs& first, const Eigen::Vector2f& at, const RowPairs& second,
                   const CurveStretch& stretch, float* scores);

private:
    bool cut_patch(const RowPairs& image, const Eigen::Vector2f& at, const CurveStretch& stretch);
    void cut_strip(const RowPairs& image, const CurveStretch& stretch);
    /// Grey values at a grid of places, as many rows as the window has: columns are at column_u_, column_v_ from
    /// `origin`, rows `down` from one another.
    void cut(const RowPairs& image, const Eigen::Vector2f& origin, const Eigen::Vector2f& down, int columns,
             float* grid) const;
    bool is_inside(const RowPairs& image, const Eigen::Vector2f& origin, const Eigen::Vector2f& down,
                   int columns) const;
    template <bool kInside>
    void cut_rows(const RowPairs& image, const Eigen::Vector2f& origin, const Eigen::Vector2f& down, int columns,
                  float* grid) const;
    template <bool kInside>
    void cut_end(const RowPairs& image, const Eigen::Vector2f& origin, const Eigen::Vector2f& down, int first,
                 int columns, float* grid) const;
    void slide(int count, float* scores) const;
    template <int kVectors>
    void slide_vectors(int first, int count, float* scores) const;

    PatchWindow window_;
    int pitch_ = 0;          ///< columns of patch and strip in storage
    float contrast_ = 0.0F;  ///< weighted sum of squared grey values of the patch about their mean
    Eigen::Vector2f along_ = Eigen::Vector2f::Zero();   ///< from place to place (px)
    Eigen::Vector2f across_ = Eigen::Vector2f::Zero();  ///< unit vector normal to it
    std::vector<float> weights_;                        ///< of the square window, 0 outside its disk
    std::vector<float> patch_;                          ///< times weights
    std::vector<float> strip_;
    std::vector<float> column_u_;  ///< places of the columns of patch or strip (px)
    std::vector<float> column_v_;
};

}  // namespace facet
