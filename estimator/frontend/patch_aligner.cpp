// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/patch_aligner.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstring>

namespace facet {
namespace {

constexpr int kLanes = 4;              // pixels worked on together: one SSE or NEON register
constexpr float kMinVariance = 4.0F;   // grey levels^2: below, a patch is noise
constexpr float kMinCurvature = 2.0F;  // least eigenvalue of the normal matrix of the position, per pixel
constexpr float kMinGain = 0.15F;
constexpr float kMaxGain = 6.0F;
constexpr float kWeightSigma = 0.8F;  // of the window's half width
constexpr float kMaxAffineStep = 0.5F;
constexpr float kGreyOrigin = 128.0F;  // subtracted first: keeps sums of squares small

struct Pattern {
    const float* u;
    const float* v;
    const float* weight;
    int count;
};

using Floats = float __attribute__((vector_size(4 * kLanes)));
using Ints = std::int32_t __attribute__((vector_size(4 * kLanes)));

Floats load(const float* p) {
    Floats v;
    std::memcpy(&v, p, sizeof(v));
    return v;
}

/// The 2x2 pixels from p: bytes p[0], p[1], then those of the next row.
std::int32_t load_quad(const std::uint8_t* p, std::ptrdiff_t stride) {
    std::uint16_t top = 0;
    std::uint16_t bottom = 0;
    std::memcpy(&top, p, 2);
    std::memcpy(&bottom, p + stride, 2);
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(top) | static_cast<std::uint32_t>(bottom) << 16U);
}

/// Sums over the pattern at centre + A x of image values s, bilinearly interpolated:
///   sums[0] = sum w s, sums[1] = sum w s^2, sums[2 + k] = sum planes[k] s for k < K.
/// The pattern must lie inside the image. This is where the front-end's time goes: vector types of the compiler, because
/// scalar stores followed by vector loads stall. Offsets are exact in float: images have fewer than 2^24 pixels.
template <int K>
void accumulate(const ImageView& image, const Pattern& pattern, const Eigen::Vector2f& centre, const Eigen::Matrix2f& A,
                const float* planes, float* sums) {
    Floats acc[K + 2] = {};
    const float stride = static_cast<float>(image.stride);
    for (int i = 0; i < pattern.count; i += kLanes) {
        const Floats x = load(pattern.u + i);
        const Floats y = load(pattern.v + i);
        const Floats u = centre.x() + (A(0, 0) * x + A(0, 1) * y);
        const Floats v = centre.y() + (A(1, 0) * x + A(1, 1) * y);
        const Floats iu = __builtin_convertvector(__builtin_convertvector(u, Ints), Floats);
        const Floats iv = __builtin_convertvector(__builtin_convertvector(v, Ints), Floats);
        const Floats fu = u - iu;
        const Floats fv = v - iv;
        const Ints at = __builtin_convertvector(iv * stride + iu, Ints);
        const Ints quad = {load_quad(image.data + at[0], image.stride), load_quad(image.data + at[1], image.stride),
                           load_quad(image.data + at[2], image.stride), load_quad(image.data + at[3], image.stride)};
        const Floats p0 = __builtin_convertvector(quad & 255, Floats);
        const Floats p1 = __builtin_convertvector((quad >> 8) & 255, Floats);
        const Floats q0 = __builtin_convertvector((quad >> 16) & 255, Floats);
        const Floats q1 = __builtin_convertvector((quad >> 24) & 255, Floats);
        const Floats top = p0 + fu * (p1 - p0);
        const Floats bottom = q0 + fu * (q1 - q0);
        const Floats s = top + fv * (bottom - top) - kGreyOrigin;
        const Floats ws = load(pattern.weight + i) * s;
        acc[0] += ws;
        acc[1] += ws * s;
        for (int j = 0; j < K; ++j) {
            acc[2 + j] += load(planes + j * pattern.count + i) * s;
        }
    }
    for (int j = 0; j < K + 2; ++j) {
        sums[j] = (acc[j][0] + acc[j][2]) + (acc[j][1] + acc[j][3]);
    }
}

}  // namespace

Status PatchAligner::configure(int window_px, int levels, int max_iterations, double epsilon_px) {
    if (window_px < 5 || window_px % 2 == 0 || levels < 1 || levels > ImagePyramid::kMaxLevels) {
        return Status::kInvalidArgument;
    }
    window_ = window_px;
    levels_ = levels;
    max_iterations_ = max_iterations;
    epsilon_px_ = static_cast<float>(epsilon_px);
    weights_.clear();
    grid_u_.clear();
    grid_v_.clear();
    const int half = window_px / 2;
    const float sigma = kWeightSigma * (static_cast<float>(half) + 1.0F);
    for (int v = -half; v <= half; ++v) {
        for (int u = -half; u <= half; ++u) {
            const float r2 = static_cast<float>(u * u + v * v);
            if (r2 <= (static_cast<float>(half) + 0.5F) * (static_cast<float>(half) + 0.5F)) {
                grid_u_.push_back(static_cast<float>(u));
                grid_v_.push_back(static_cast<float>(v));
                weights_.push_back(std::exp(-r2 / (2.0F * sigma * sigma)));
            }
        }
    }
    while (weights_.size() % kLanes != 0) {
        grid_u_.push_back(0.0F);
        grid_v_.push_back(0.0F);
        weights_.push_back(0.0F);
    }
    count_ = static_cast<int>(weights_.size());
    weight_sum_ = 0.0F;
    for (const float w : weights_) {
        weight_sum_ += w;
    }
    work_.assign(static_cast<std::size_t>(3 * count_), 0.0F);
    return Status::kOk;
}

void PatchAligner::allocate(PatchTemplate& patch) const {
    patch.planes.assign(static_cast<std::size_t>((7 + 3 * (levels_ - 1)) * count_), 0.0F);
}

bool PatchAligner::extract_level(const ImageView& image, const Eigen::Vector2d& at, bool affine,
                                 PatchTemplate::Level& level, float* planes, Eigen::Matrix<float, 6, 6>& inverse6) {
    using Array = Eigen::Map<Eigen::ArrayXf>;
    using ConstArray = Eigen::Map<const Eigen::ArrayXf>;
    const int half = window_ / 2;
    const int cu = static_cast<int>(std::lround(at.x()));
    const int cv = static_cast<int>(std::lround(at.y()));
    if (cu - half < 1 || cv - half < 1 || cu + half + 1 >= image.width || cv + half + 1 >= image.height) {
        return false;
    }
    level.offset = (Eigen::Vector2d(cu, cv) - at).cast<float>();
    Array t(work_.data(), count_);
    Array gu(work_.data() + count_, count_);
    Array gv(work_.data() + 2 * count_, count_);
    for (int i = 0; i < count_; ++i) {
        const std::size_t k = static_cast<std::size_t>(i);
        const std::uint8_t* p = image.row(cv + static_cast<int>(grid_v_[k])) + cu + static_cast<int>(grid_u_[k]);
        t[i] = *p;
        gu[i] = 0.5F * static_cast<float>(p[1] - p[-1]);
        gv[i] = 0.5F * static_cast<float>(p[image.stride] - p[-image.stride]);
    }
    const ConstArray w(weights_.data(), count_);
    t -= (w * t).sum() / weight_sum_;
    Array wt(planes, count_);
    wt = w * t;
    level.contrast = (wt * t).sum();
    if (!(level.contrast > kMinVariance * weight_sum_)) {
        return false;
    }
    // J = P [gu gv gu*x gu*y gv*x gv*y]; P removes the components along 1 and T (in the weighted product).
    const ConstArray x(grid_u_.data(), count_);
    const ConstArray y(grid_v_.data(), count_);
    const int unknowns = affine ? 6 : 2;
    Eigen::Matrix<float, 6, 6> normal = Eigen::Matrix<float, 6, 6>::Identity();
    for (int k = 0; k < unknowns; ++k) {
        Array wj(planes + (1 + k) * count_, count_);
        const Array& g = k == 0 || k == 2 || k == 3 ? gu : gv;
        if (k < 2) {
            wj = g;
        } else if (k % 2 == 0) {
            wj = g * (x + level.offset.x());
        } else {
            wj = g * (y + level.offset.y());
        }
        const float along_one = (w * wj).sum() / weight_sum_;
        const float along_t = (wt * wj).sum() / level.contrast;
        wj = w * (wj - along_one - along_t * t);
        // (P a)^T W b: the projection need be applied to one factor only.
        normal(k, 0) = (wj * gu).sum();
        normal(k, 1) = (wj * gv).sum();
        if (affine) {
            const float ox = level.offset.x();
            const float oy = level.offset.y();
            normal(k, 2) = (wj * gu * (x + ox)).sum();
            normal(k, 3) = (wj * gu * (y + oy)).sum();
            normal(k, 4) = (wj * gv * (x + ox)).sum();
            normal(k, 5) = (wj * gv * (y + oy)).sum();
        }
    }
    const float trace = normal(0, 0) + normal(1, 1);
    const float det = normal(0, 0) * normal(1, 1) - normal(0, 1) * normal(1, 0);
    const float least = 0.5F * (trace - std::sqrt(std::max(0.0F, trace * trace - 4.0F * det)));
    if (!(least > kMinCurvature * weight_sum_)) {
        return false;
    }
    level.inverse2 = normal.topLeftCorner<2, 2>().inverse();
    if (affine) {
        normal.diagonal() *= 1.0F + 1e-3F;
        inverse6 = normal.inverse();
    }
    return true;
}

Status PatchAligner::extract(const ImagePyramid& image, const Eigen::Vector2d& uv, const ExtractOptions& options,
                             PatchTemplate& patch) {
    for (int l = 0; l < levels_; ++l) {
        PatchTemplate::Level& level = patch.levels[static_cast<std::size_t>(l)];
        float* out = patch.planes.data() + (planes(patch, l) - patch.planes.data());
        level.valid = l <= options.coarsest && extract_level(image.level(l), uv / static_cast<double>(1 << l),
                                                             options.affine && l == 0, level, out, patch.inverse6);
    }
    if (patch.levels[0].valid) {
        return Status::kOk;
    }
    const ImageView& full = image.level(0);
    const bool inside = uv.x() >= border_px() && uv.y() >= border_px() && uv.x() <= full.width - 1 - border_px() &&
                        uv.y() <= full.height - 1 - border_px();
    return inside ? Status::kDegenerate : Status::kNotFound;
}

bool PatchAligner::covers(const ImageView& image, const Eigen::Vector2f& centre, const Eigen::Matrix2f& A) const {
    const auto half = static_cast<float>(half_window());
    const Eigen::Array2f reach = (A.col(0).array().abs() + A.col(1).array().abs()) * half;
    return centre.x() - reach.x() >= 0.0F && centre.y() - reach.y() >= 0.0F &&
           centre.x() + reach.x() < static_cast<float>(image.width - 1) &&
           centre.y() + reach.y() < static_cast<float>(image.height - 1);
}

Status PatchAligner::align_level(const PatchTemplate& patch, const ImageView& image, int l, bool affine,
                                 PatchPose& pose, float& correlation) const {
    const PatchTemplate::Level& level = patch.levels[static_cast<std::size_t>(l)];
    const Pattern pattern{grid_u_.data(), grid_v_.data(), weights_.data(), count_};
    const double scale = static_cast<double>(1 << l);
    const float epsilon = l == 0 ? epsilon_px_ : std::max(epsilon_px_, 0.05F);
    Eigen::Vector2f at = (pose.uv / scale).cast<float>();
    Eigen::Matrix2f A = pose.A;
    const Eigen::Vector2f start = at;
    for (int step = 0; step < max_iterations_; ++step) {
        const Eigen::Vector2f centre = at + A * level.offset;
        if (!covers(image, centre, A)) {
            return Status::kNotFound;
        }
        float sums[9];
        if (affine) {
            accumulate<7>(image, pattern, centre, A, planes(patch, l), sums);
        } else {
            accumulate<3>(image, pattern, centre, A, planes(patch, l), sums);
        }
        const float gain = sums[2] / level.contrast;
        const float energy = sums[1] - sums[0] * sums[0] / weight_sum_;
        if (!(gain > kMinGain && gain < kMaxGain && energy > 0.0F)) {
            return Status::kDegenerate;
        }
        correlation = sums[2] / std::sqrt(level.contrast * energy);
        Eigen::Vector2f d;
        if (affine) {
            const Eigen::Matrix<float, 6, 1> delta =
                patch.inverse6 * Eigen::Map<const Eigen::Matrix<float, 6, 1>>(sums + 3) / gain;
            if (!(delta.tail<4>().cwiseAbs().maxCoeff() < kMaxAffineStep)) {
                return Status::kDegenerate;
            }
            Eigen::Matrix2f change;
            change << 1.0F + delta[2], delta[3], delta[4], 1.0F + delta[5];
            A = A * change.inverse();
            d = delta.head<2>();
        } else {
            d = level.inverse2 * Eigen::Vector2f(sums[3], sums[4]) / gain;
        }
        at -= A * d;
        // A step beyond the window means that the linearization has nothing to do with the image.
        if (!((at - start).squaredNorm() < 0.25F * static_cast<float>(window_ * window_))) {
            return Status::kDegenerate;
        }
        if (d.squaredNorm() < epsilon * epsilon) {
            break;
        }
    }
    pose.A = A;
    pose.uv = at.cast<double>() * scale;
    return Status::kOk;
}

Status PatchAligner::align(const PatchTemplate& patch, const ImagePyramid& image, const AlignOptions& options,
                           PatchPose& pose, float& correlation) const {
    PatchPose refined = pose;
    float value = 0.0F;
    for (int l = std::min(options.coarsest, levels_ - 1); l >= options.finest; --l) {
        const bool last = l == options.finest;
        if (!patch.levels[static_cast<std::size_t>(l)].valid) {
            if (last) {
                return Status::kDegenerate;
            }
            continue;
        }
        const Status status = align_level(patch, image.level(l), l, options.affine && l == 0, refined, value);
        if (last && !ok(status)) {
            return status;
        }
    }
    if (!(value > options.min_correlation)) {
        return Status::kDegenerate;
    }
    pose = refined;
    correlation = value;
    return Status::kOk;
}

float PatchAligner::correlate(const PatchTemplate& patch, const ImagePyramid& image, int l,
                              const PatchPose& pose) const {
    const PatchTemplate::Level& level = patch.levels[static_cast<std::size_t>(l)];
    const Eigen::Vector2f centre = (pose.uv / static_cast<double>(1 << l)).cast<float>() + pose.A * level.offset;
    if (!level.valid || !covers(image.level(l), centre, pose.A)) {
        return -1.0F;
    }
    float sums[3];
    accumulate<1>(image.level(l), {grid_u_.data(), grid_v_.data(), weights_.data(), count_}, centre, pose.A,
                  planes(patch, l), sums);
    const float energy = sums[1] - sums[0] * sums[0] / weight_sum_;
    if (!(energy > 0.25F * kMinVariance * weight_sum_)) {
        return -1.0F;
    }
    return sums[2] / std::sqrt(level.contrast * energy);
}

}  // namespace facet
