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
constexpr float kInside = 1e-3F;

Floats sample_clamped(const RowPairs& image, const Floats& u, const Floats& v) {
    return simd::sample(image, simd::clamp(u, 0.0F, static_cast<float>(image.width - 1) - kInside),
                        simd::clamp(v, 0.0F, static_cast<float>(image.height - 1) - kInside)) -
           PatchWindow::kGreyOrigin;
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
    const Floats count = counting();
    float sum = 0.0F;
    for (int v = 0; v < window_.side(); ++v) {
        const float dv = static_cast<float>(v) - half;
        float* const row = patch_.data() + v * pitch_;
        const float* const weights = weights_.data() + v * pitch_;
        for (int u = 0; u < window_.side(); u += kLanes) {
            const Floats du = count + (static_cast<float>(u) - half);
            const Floats grey =
                sample_clamped(image, at.x() + dv * y.x() + du * x.x(), at.y() + dv * y.y() + du * x.y());
            simd::store(row + u, grey);
            sum += simd::sum(simd::load(weights + u) * grey);
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
    const Floats count = counting();
    for (int j = 0; j < pitch_; j += kLanes) {
        const Floats t = (count + static_cast<float>(j - half)) / static_cast<float>(s.count);
        const Floats f = (2.0F * t - 3.0F) * t + 1.0F;
        const Floats m = 4.0F * t * (1.0F - t);
        const Floats l = (2.0F * t - 1.0F) * t;
        simd::store(column_u_.data() + j, f * s.first.x() + m * s.middle.x() + l * s.last.x());
        simd::store(column_v_.data() + j, f * s.first.y() + m * s.middle.y() + l * s.last.y());
    }
    const int columns = s.count + window_.side() - 1;
    for (int v = 0; v < window_.side(); ++v) {
        const Eigen::Vector2f off = static_cast<float>(v - half) * across_;
        for (int j = 0; j < columns; j += kLanes) {
            simd::store(strip_.data() + v * pitch_ + j,
                        sample_clamped(image, simd::load(column_u_.data() + j) + off.x(),
                                       simd::load(column_v_.data() + j) + off.y()));
        }
    }
}

void EpipolarScan::slide(int count, float* scores) const {
    for (int i = 0; i < count; i += kLanes) {
        Floats sum{};
        Floats squares{};
        Floats product{};
        for (const PatchWindow::Row& row : window_.rows()) {
            const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(row.v + window_.half()) * pitch_;
            for (int u = window_.half() - row.half; u <= window_.half() + row.half; ++u) {
                const Floats s = simd::load(strip_.data() + at + u + i);
                const Floats ws = weights_[static_cast<std::size_t>(at + u)] * s;
                sum += ws;
                squares = simd::multiply_add(ws, s, squares);
                product = simd::multiply_add(simd::splat(patch_[static_cast<std::size_t>(at + u)]), s, product);
            }
        }
        const Floats energy = squares - sum * sum / window_.weight_sum();
        const float least = 0.25F * PatchWindow::kMinVariance * window_.weight_sum();
        for (int k = 0; k < kLanes && i + k < count; ++k) {
            scores[i + k] = energy[k] > least ? product[k] / std::sqrt(contrast_ * energy[k]) : -1.0F;
        }
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
    for (int i = 0; i < stretch.count; ++i) {
        const std::size_t column = static_cast<std::size_t>(i + window_.half());
        const float u = column_u_[column];
        const float v = column_v_[column];
        if (!(u - reach.x() >= 0.0F && v - reach.y() >= 0.0F && u + reach.x() < static_cast<float>(second.width - 1) &&
              v + reach.y() < static_cast<float>(second.height - 1))) {
            scores[i] = -1.0F;
        }
    }
}

}  // namespace facet
