// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/epipolar_scan.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "estimator/frontend/simd.h"

namespace facet {
namespace {

using simd::Floats;
using simd::kLanes;

constexpr float kShortestStep = 0.5F;  // px between places: beyond these the patch would be squeezed or torn
constexpr float kLongestStep = 1.7F;
constexpr float kInsideMargin = 1e-3F;
constexpr int kFewColumns = kLanes / 4;  // at the end of a grid's rows: a vector holds those of several rows

/// @tparam kInside  all places are inside the image
/// @tparam kAlong   see simd::sample()
template <bool kInside, bool kAlong>
Floats sample(const RowPairs& image, const Floats& u, const Floats& v) {
    if constexpr (kInside) {
        return simd::sample<kAlong>(image, u, v) - PatchWindow::kGreyOrigin;
    } else {
        return simd::sample<kAlong>(image, simd::clamp(u, 0.0F, static_cast<float>(image.width - 1) - kInsideMargin),
                                    simd::clamp(v, 0.0F, static_cast<float>(image.height - 1) - kInsideMargin)) -
               PatchWindow::kGreyOrigin;
    }
}

Floats counting() {
    Floats v;
    for (int i = 0; i < kLanes; ++i) {
        v[i] = static_cast<float>(i);
    }
    return v;
}

}  // namespace

void EpipolarScan::configure(int window_px) {
    window_.configure(window_px);
    // A vector of places reaches to its last column plus the window.
    pitch_ = CurveStretch::kMaxPlaces + window_px - 1 + kLanes;
    pitch_ -= pitch_ % kLanes;
    const auto size = static_cast<std::size_t>(window_px * pitch_);
    weights_.assign(size, 0.0F);
    for (int v = 0; v < window_px; ++v) {
        for (int u = 0; u < window_px; ++u) {
            weights_[static_cast<std::size_t>(v * pitch_ + u)] = window_.weight(u - window_.half(), v - window_.half());
        }
    }
    patch_.assign(size, 0.0F);
    strip_.assign(size, 0.0F);
    column_u_.assign(static_cast<std::size_t>(pitch_), 0.0F);
    column_v_.assign(static_cast<std::size_t>(pitch_), 0.0F);
}

bool EpipolarScan::suits(const CurveStretch& s) {
    if (s.count <= 0 || s.count > CurveStretch::kMaxPlaces) {
        return false;
    }
    const float half = 0.5F * static_cast<float>(s.count);
    const float near = (s.middle - s.first).norm();
    const float far = (s.last - s.middle).norm();
    return std::min(near, far) > kShortestStep * half && std::max(near, far) < kLongestStep * half &&
           std::abs(s.A.determinant()) > 0.1F;
}

bool EpipolarScan::cut_patch(const RowPairs& image, const Eigen::Vector2f& at, const CurveStretch& stretch) {
    const Eigen::Matrix2f back = stretch.A.inverse();
    const Eigen::Vector2f x = back * along_;
    const Eigen::Vector2f y = back * across_;
    const auto half = static_cast<float>(window_.half());
    for (int u = 0; u < window_.side(); u += kLanes) {
        const Floats du = counting() + (static_cast<float>(u) - half);
        simd::store(column_u_.data() + u, du * x.x());
        simd::store(column_v_.data() + u, du * x.y());
    }
    cut(image, at, y, window_.side(), patch_.data());
    float sum = 0.0F;
    for (int v = 0; v < window_.side(); ++v) {
        for (int u = 0; u < window_.side(); u += kLanes) {
            sum += simd::sum(simd::load(weights_.data() + v * pitch_ + u) * simd::load(patch_.data() + v * pitch_ + u));
        }
    }
    const float mean = sum / window_.weight_sum();
    Floats contrast{};
    for (int v = 0; v < window_.side(); ++v) {
        for (int u = 0; u < window_.side(); u += kLanes) {
            float* const p = patch_.data() + v * pitch_ + u;
            const Floats grey = simd::load(p) - mean;
            const Floats weighted = simd::load(weights_.data() + v * pitch_ + u) * grey;
            contrast += weighted * grey;
            simd::store(p, weighted);
        }
    }
    contrast_ = simd::sum(contrast);
    return contrast_ > PatchWindow::kMinVariance * window_.weight_sum();
}

void EpipolarScan::cut_strip(const RowPairs& image, const CurveStretch& s) {
    // Lagrange's parabola in t = j / count through t = 0, 1/2, 1; columns before and after it go on along it.
    const int half = window_.half();
    const int columns = s.count + window_.side() - 1;
    for (int j = 0; j < columns; j += kLanes) {
        const Floats t = (counting() + static_cast<float>(j - half)) / static_cast<float>(s.count);
        const Floats f = (2.0F * t - 3.0F) * t + 1.0F;
        const Floats m = 4.0F * t * (1.0F - t);
        const Floats l = (2.0F * t - 1.0F) * t;
        simd::store(column_u_.data() + j, f * s.first.x() + m * s.middle.x() + l * s.last.x());
        simd::store(column_v_.data() + j, f * s.first.y() + m * s.middle.y() + l * s.last.y());
    }
    cut(image, Eigen::Vector2f::Zero(), across_, columns, strip_.data());
}

/// Whether all vectors of the grid lie inside the image by more than what rounding takes.
bool EpipolarScan::is_inside(const RowPairs& image, const Eigen::Vector2f& origin, const Eigen::Vector2f& down,
                             int columns) const {
    const Eigen::Array2f reach = static_cast<float>(window_.half()) * down.array().abs() + 1.0F;
    const Eigen::Array2f low = reach - origin.array();
    const Eigen::Array2f high =
        Eigen::Array2f(static_cast<float>(image.width - 1), static_cast<float>(image.height - 1)) - reach -
        origin.array();
    simd::Ints inside = ~simd::Ints{};
    for (int j = 0; j < columns; j += kLanes) {
        const Floats u = simd::load(column_u_.data() + j);
        const Floats v = simd::load(column_v_.data() + j);
        inside &= (u > low.x()) & (u < high.x()) & (v > low.y()) & (v < high.y());
    }
    return !simd::any(~inside);
}

void EpipolarScan::cut(const RowPairs& image, const Eigen::Vector2f& origin, const Eigen::Vector2f& down, int columns,
                       float* grid) const {
    const int end = columns % kLanes <= kFewColumns ? columns - columns % kLanes : columns;
    if (is_inside(image, origin, down, columns)) {
        cut_rows<true>(image, origin, down, end, grid);
        cut_end<true>(image, origin, down, end, columns - end, grid);
    } else {
        cut_rows<false>(image, origin, down, end, grid);
        cut_end<false>(image, origin, down, end, columns - end, grid);
    }
}

template <bool kInside>
void EpipolarScan::cut_rows(const RowPairs& image, const Eigen::Vector2f& origin, const Eigen::Vector2f& down,
                            int columns, float* grid) const {
    // Copies: what is stored might otherwise change them.
    const RowPairs pairs = image;
    const float* const column_u = column_u_.data();
    const float* const column_v = column_v_.data();
    const int half = window_.half();
    for (int v = -half; v <= half; ++v, grid += pitch_) {
        const Eigen::Vector2f row = origin + static_cast<float>(v) * down;
        const Floats row_u = simd::splat(row.x());
        const Floats row_v = simd::splat(row.y());
        for (int j = 0; j < columns; j += kLanes) {
            simd::store(grid + j, sample<kInside, true>(pairs, row_u + simd::load(column_u + j),
                                                        row_v + simd::load(column_v + j)));
        }
    }
}

/// The last few columns, from `first` on: a vector holds those of several rows.
template <bool kInside>
void EpipolarScan::cut_end(const RowPairs& image, const Eigen::Vector2f& origin, const Eigen::Vector2f& down, int first,
                           int columns, float* grid) const {
    if (columns == 0) {
        return;
    }
    const int rows = kLanes / columns;
    Floats row{};
    Floats u{};
    Floats v{};
    for (int i = 0; i < kLanes; ++i) {
        const auto column = static_cast<std::size_t>(first + i % columns);
        row[i] = static_cast<float>(std::min(i / columns, rows - 1));
        u[i] = column_u_[column];
        v[i] = column_v_[column];
    }
    for (int begin = 0; begin < window_.side(); begin += rows) {
        const int count = std::min(rows, window_.side() - begin);
        Floats dv = row + static_cast<float>(begin - window_.half());
        const auto last = static_cast<float>(window_.half());
        dv = dv > last ? simd::splat(last) : dv;
        float grey[kLanes];
        simd::store(grey,
                    sample<kInside, false>(image, (origin.x() + dv * down.x()) + u, (origin.y() + dv * down.y()) + v));
        for (int k = 0; k < count; ++k) {
            std::copy_n(grey + k * columns, columns, grid + (begin + k) * pitch_ + first);
        }
    }
}

/// The window's weights and the patch are broadcast once for all of these vectors of places.
template <int kVectors>
void EpipolarScan::slide_vectors(int first, int count, float* scores) const {
    Floats sum[kVectors] = {};
    Floats squares[kVectors] = {};
    Floats product[kVectors] = {};
    for (const PatchWindow::Row& row : window_.rows()) {
        const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(row.v + window_.half()) * pitch_;
        const std::ptrdiff_t end = at + window_.half() + row.half;
        for (std::ptrdiff_t i = at + window_.half() - row.half; i <= end; ++i) {
            const Floats w = simd::splat(weights_[static_cast<std::size_t>(i)]);
            const Floats p = simd::splat(patch_[static_cast<std::size_t>(i)]);
            const float* const strip = strip_.data() + i + first;
            for (int k = 0; k < kVectors; ++k) {
                const Floats s = simd::load(strip + k * kLanes);
                const Floats ws = w * s;
                sum[k] += ws;
                squares[k] = simd::multiply_add(ws, s, squares[k]);
                product[k] = simd::multiply_add(p, s, product[k]);
            }
        }
    }
    const float least = 0.25F * PatchWindow::kMinVariance * window_.weight_sum();
    for (int k = 0; k < kVectors; ++k) {
        const Floats energy = squares[k] - sum[k] * sum[k] / window_.weight_sum();
        const int begin = first + k * kLanes;
        for (int i = 0; i < kLanes && begin + i < count; ++i) {
            scores[begin + i] = energy[i] > least ? product[k][i] / std::sqrt(contrast_ * energy[i]) : -1.0F;
        }
    }
}

void EpipolarScan::slide(int count, float* scores) const {
    constexpr int kMost = 4;  // vectors at a time: their sums fill the registers
    int first = 0;
    for (; count - first > 3 * kLanes; first += kMost * kLanes) {
        slide_vectors<kMost>(first, count, scores);
    }
    if (count - first > 2 * kLanes) {
        slide_vectors<3>(first, count, scores);
    } else if (count - first > kLanes) {
        slide_vectors<2>(first, count, scores);
    } else if (count > first) {
        slide_vectors<1>(first, count, scores);
    }
}

void EpipolarScan::correlate(const RowPairs& first, const Eigen::Vector2f& at, const RowPairs& second,
                             const CurveStretch& stretch, float* scores) {
    along_ = (stretch.last - stretch.first) / static_cast<float>(stretch.count);
    across_ = Eigen::Vector2f(-along_.y(), along_.x()).normalized();
    if (!cut_patch(first, at, stretch)) {
        std::fill_n(scores, stretch.count, -1.0F);
        return;
    }
    cut_strip(second, stretch);
    slide(stretch.count, scores);
    const auto half = static_cast<float>(window_.half());
    const Eigen::Array2f reach = half * (along_.array().abs() + across_.array().abs());
    for (int i = 0; i < stretch.count; i += kLanes) {
        const Floats u = simd::load(column_u_.data() + window_.half() + i);
        const Floats v = simd::load(column_v_.data() + window_.half() + i);
        const simd::Ints is_covered = (u - reach.x() >= 0.0F) & (v - reach.y() >= 0.0F) &
                                      (u + reach.x() < static_cast<float>(second.width - 1)) &
                                      (v + reach.y() < static_cast<float>(second.height - 1));
        if (!simd::any(is_covered == 0)) {
            continue;  // as nearly everywhere
        }
        for (int k = 0; k < kLanes && i + k < stretch.count; ++k) {
            scores[i + k] = is_covered[k] != 0 ? scores[i + k] : -1.0F;
        }
    }
}

}  // namespace facet
