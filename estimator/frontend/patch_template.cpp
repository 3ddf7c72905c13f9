// SPDX-License-Identifier: BSD-2-Clause
// The part of PatchAligner that cuts templates.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "estimator/frontend/patch_aligner.h"
#include "estimator/frontend/simd.h"

namespace facet {
namespace {

using simd::Floats;

constexpr float kMinCurvature = 2.0F;  // least eigenvalue of the normal matrix of the position, per pixel

/// A patch as cut from the image: grey values and their gradients, pixel by pixel of the window.
struct Cut {
    float* grey;
    const float* gu;
    const float* gv;
};

/// Steepest-descent images at kLanes pixels: [gu gv], or [gu gv gu*x gu*y gv*x gv*y] with x, y counted from the anchor.
template <int K>
struct Descent {
    Floats j[K];

    Descent(const Cut& cut, const PatchWindow& window, const Eigen::Vector2f& offset, int i) {
        j[0] = simd::load(cut.gu + i);
        j[1] = simd::load(cut.gv + i);
        if constexpr (K == 6) {
            const Floats x = simd::load(window.u() + i) + offset.x();
            const Floats y = simd::load(window.v() + i) + offset.y();
            j[2] = j[0] * x;
            j[3] = j[0] * y;
            j[4] = j[1] * x;
            j[5] = j[1] * y;
        }
    }
};

/// Weighted sums over a patch: T^2, and with every steepest-descent image j its sum, that of T j, and of all products.
template <int K>
struct Moments {
    float contrast = 0.0F;
    float one[K];
    float grey[K];
    Eigen::Matrix<float, K, K> products;
};

/// Takes the mean from the grey values, writes W T to `weighted`, and sums up.
template <int K>
Moments<K> sum_up(const Cut& cut, const PatchWindow& window, const Eigen::Vector2f& offset, float* weighted) {
    Floats total{};
    for (int i = 0; i < window.count(); i += simd::kLanes) {
        total += simd::load(window.weights() + i) * simd::load(cut.grey + i);
    }
    const float mean = simd::sum(total) / window.weight_sum();
    Floats contrast{};
    Floats one[K] = {};
    Floats grey[K] = {};
    Floats products[K * (K + 1) / 2] = {};
    for (int i = 0; i < window.count(); i += simd::kLanes) {
        const Floats w = simd::load(window.weights() + i);
        const Floats t = simd::load(cut.grey + i) - mean;
        const Floats wt = w * t;
        simd::store(cut.grey + i, t);
        simd::store(weighted + i, wt);
        contrast += wt * t;
        const Descent<K> d(cut, window, offset, i);
        for (int a = 0, k = 0; a < K; ++a) {
            const Floats wj = w * d.j[a];
            one[a] += wj;
            grey[a] = simd::multiply_add(wt, d.j[a], grey[a]);
            for (int b = 0; b <= a; ++b, ++k) {
                products[k] = simd::multiply_add(wj, d.j[b], products[k]);
            }
        }
    }
    Moments<K> moments;
    moments.contrast = simd::sum(contrast);
    for (int a = 0, k = 0; a < K; ++a) {
        moments.one[a] = simd::sum(one[a]);
        moments.grey[a] = simd::sum(grey[a]);
        for (int b = 0; b <= a; ++b, ++k) {
            moments.products(a, b) = moments.products(b, a) = simd::sum(products[k]);
        }
    }
    return moments;
}

/// Least eigenvalue of the 2x2 corner.
template <class M>
float least_eigenvalue(const M& m) {
    const float trace = m(0, 0) + m(1, 1);
    const float det = m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0);
    return 0.5F * (trace - std::sqrt(std::max(0.0F, trace * trace - 4.0F * det)));
}

/// The inverse of a positive definite matrix by its Cholesky factor; not finite if it is not one. Written out: Eigen's
/// solvers take ten times as long to copy so few numbers about.
template <int K>
Eigen::Matrix<float, K, K> inverse_of(const Eigen::Matrix<float, K, K>& m) {
    Eigen::Matrix<float, K, K> l;                                       // the factor below its diagonal
    Eigen::Matrix<float, K, K> x = Eigen::Matrix<float, K, K>::Zero();  // its inverse
    for (int j = 0; j < K; ++j) {
        float pivot = m(j, j);
        for (int k = 0; k < j; ++k) {
            pivot -= l(j, k) * l(j, k);
        }
        x(j, j) = 1.0F / std::sqrt(pivot);
        for (int i = j + 1; i < K; ++i) {
            float sum = m(i, j);
            for (int k = 0; k < j; ++k) {
                sum -= l(i, k) * l(j, k);
            }
            l(i, j) = sum * x(j, j);
        }
        for (int i = 0; i < j; ++i) {
            float sum = 0.0F;
            for (int k = i; k < j; ++k) {
                sum += l(j, k) * x(k, i);
            }
            x(j, i) = -sum * x(j, j);
        }
    }
    return x.transpose().lazyProduct(x);
}

}  // namespace

void PatchAligner::cut(const ImageView& image, int u, int v) {
    const int pitch = window_.count() + simd::kLanes;
    float* const t = work_.data();
    float* const gu = t + pitch;
    float* const gv = gu + pitch;
    for (const PatchWindow::Row& row : window_.rows()) {
        const std::uint8_t* const p = image.row(v + row.v) + u - row.half;
        const int length = 2 * row.half + 1;
        // The last vector of a row overruns; the next row overwrites what is not its own.
        for (int k = 0; k < length; k += simd::kLanes) {
            const int at = row.first + k;
            simd::store(t + at, simd::load_bytes(p + k));
            simd::store(gu + at, 0.5F * (simd::load_bytes(p + k + 1) - simd::load_bytes(p + k - 1)));
            simd::store(gv + at,
                        0.5F * (simd::load_bytes(p + k + image.stride) - simd::load_bytes(p + k - image.stride)));
        }
    }
}

template <bool kAffine>
bool PatchAligner::extract_level(const ImageView& image, const Eigen::Vector2d& at, PatchTemplate::Level& level,
                                 float* planes, Eigen::Matrix<float, 6, 6>& inverse6) {
    constexpr int kUnknowns = kAffine ? 6 : 2;
    const int half = window_.half();
    const int cu = static_cast<int>(std::lround(at.x()));
    const int cv = static_cast<int>(std::lround(at.y()));
    if (cu - half < 1 || cv - half < 1 || cu + half + 1 >= image.width || cv + half + 1 >= image.height) {
        return false;
    }
    level.offset = (Eigen::Vector2d(cu, cv) - at).cast<float>();
    cut(image, cu, cv);
    const int count = window_.count();
    const int pitch = count + simd::kLanes;
    const Cut patch{work_.data(), work_.data() + pitch, work_.data() + 2 * pitch};
    Moments<kUnknowns> m = sum_up<kUnknowns>(patch, window_, level.offset, planes);
    level.contrast = m.contrast;
    if (!(level.contrast > PatchWindow::kMinVariance * window_.weight_sum())) {
        return false;
    }
    // J = P j; P removes the components along 1 and T (in the weighted product), here first from the products.
    for (int a = 0; a < kUnknowns; ++a) {
        for (int b = 0; b < kUnknowns; ++b) {
            m.products(a, b) -= m.one[a] * m.one[b] / window_.weight_sum() + m.grey[a] * m.grey[b] / level.contrast;
        }
    }
    if (!(least_eigenvalue(m.products) > kMinCurvature * window_.weight_sum())) {
        return false;
    }
    for (int a = 0; a < kUnknowns; ++a) {
        level.by_one(a) = m.one[a] / window_.weight_sum();
        level.by_grey(a) = m.grey[a] / level.contrast;
    }
    for (int i = 0; i < count; i += simd::kLanes) {
        const Floats w = simd::load(window_.weights() + i);
        simd::store(planes + count + i, w * simd::load(patch.gu + i));
        simd::store(planes + 2 * count + i, w * simd::load(patch.gv + i));
    }
    level.inverse2 = m.products.template topLeftCorner<2, 2>().inverse();
    if constexpr (kAffine) {
        m.products.diagonal() *= 1.0F + 1e-3F;
        inverse6 = inverse_of(m.products);
    }
    return true;
}

Status PatchAligner::extract(const ImagePyramid& image, const Eigen::Vector2d& uv, const ExtractOptions& options,
                             PatchTemplate& patch) {
    for (int l = 0; l < levels_; ++l) {
        PatchTemplate::Level& level = patch.levels[static_cast<std::size_t>(l)];
        level.valid = false;
        if (l > options.coarsest) {
            continue;
        }
        float* const out = patch.planes.data() + plane_offset(l);
        const Eigen::Vector2d at = uv / static_cast<double>(1 << l);
        level.valid = l == 0 && options.affine ? extract_level<true>(image.level(l), at, level, out, patch.inverse6)
                                               : extract_level<false>(image.level(l), at, level, out, patch.inverse6);
        if (l == 0 && !level.valid) {
            break;
        }
    }
    if (patch.levels[0].valid) {
        return Status::kOk;
    }
    const ImageView& full = image.level(0);
    const bool inside = uv.x() >= border_px() && uv.y() >= border_px() && uv.x() <= full.width - 1 - border_px() &&
                        uv.y() <= full.height - 1 - border_px();
    return inside ? Status::kDegenerate : Status::kNotFound;
}

}  // namespace facet
