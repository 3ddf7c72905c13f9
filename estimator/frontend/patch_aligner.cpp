// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/patch_aligner.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "estimator/frontend/simd.h"

namespace facet {
namespace {

using simd::Floats;
using simd::multiply_add;
using simd::splat;

constexpr float kMinGain = 0.15F;
constexpr float kMaxGain = 6.0F;
constexpr float kMaxAffineStep = 0.5F;
constexpr float kCoarseEpsilonPx = 0.05F;  // of a coarse level's pixels; 0.1 and 0.2 make tracks less precise

/// How much accumulate() sums up.
enum class Sums : std::uint8_t { kCorrelation, kPosition, kAffine };
constexpr int kMostSums = 9;

/// Sums over the window at centre + A x of image values s, bilinearly interpolated, with the template's planes:
///   sums = w s, w s^2, wT s;  for kPosition also wgu s, wgv s;  for kAffine also wgu x s, wgu y s, wgv x s, wgv y s,
/// x and y counted from the patch's centre. The window must lie inside the image. Most of the front-end's time is spent
/// here.
template <Sums kWanted>
void accumulate(const RowPairs& image, const PatchWindow& window, const Eigen::Vector2f& centre,
                const Eigen::Matrix2f& A, const float* planes, float* sums) {
    static_assert(PatchWindow::kGreyOrigin == simd::kGreyOrigin);
    constexpr int kCount = kWanted == Sums::kAffine ? kMostSums : kWanted == Sums::kPosition ? 5 : 3;
    const Eigen::Vector2f c = simd::kPositionScale * centre;
    const Eigen::Matrix2f a = simd::kPositionScale * A;
    Floats acc[kCount] = {};
    const int count = window.count();
    for (int i = 0; i < count; i += simd::kLanes) {
        const Floats x = simd::load(window.u() + i);
        const Floats y = simd::load(window.v() + i);
        const Floats u = multiply_add(splat(a(0, 0)), x, multiply_add(splat(a(0, 1)), y, splat(c.x())));
        const Floats v = multiply_add(splat(a(1, 0)), x, multiply_add(splat(a(1, 1)), y, splat(c.y())));
        const Floats s = simd::sample_scaled(image, u, v);
        const Floats ws = simd::load(window.weights() + i) * s;
        acc[0] += ws;
        acc[1] = multiply_add(ws, s, acc[1]);
        acc[2] = multiply_add(simd::load(planes + i), s, acc[2]);
        if constexpr (kWanted != Sums::kCorrelation) {
            const Floats gu = simd::load(planes + count + i) * s;
            const Floats gv = simd::load(planes + 2 * count + i) * s;
            acc[3] += gu;
            acc[4] += gv;
            if constexpr (kWanted == Sums::kAffine) {
                acc[5] = multiply_add(gu, x, acc[5]);
                acc[6] = multiply_add(gu, y, acc[6]);
                acc[7] = multiply_add(gv, x, acc[7]);
                acc[8] = multiply_add(gv, y, acc[8]);
            }
        }
    }
    for (int j = 0; j < kCount; ++j) {
        sums[j] = simd::sum(acc[j]) / simd::kGreyScale;
    }
    sums[1] /= simd::kGreyScale;
}

}  // namespace

Status PatchAligner::configure(int window_px, int levels, int max_iterations, double epsilon_px) {
    if (window_px < 5 || window_px % 2 == 0 || levels < 1 || levels > ImagePyramid::kMaxLevels) {
        return Status::kInvalidArgument;
    }
    levels_ = levels;
    max_iterations_ = max_iterations;
    epsilon_px_ = static_cast<float>(epsilon_px);
    window_.configure(window_px);
    work_.assign(static_cast<std::size_t>(3 * (window_.count() + simd::kLanes)), 0.0F);
    return Status::kOk;
}

void PatchAligner::allocate(PatchTemplate& patch) const {
    patch.planes.assign(static_cast<std::size_t>(plane_offset(levels_)), 0.0F);
}

bool PatchAligner::covers(const RowPairs& image, const Eigen::Vector2f& centre, const Eigen::Matrix2f& A) const {
    const auto half = static_cast<float>(window_.half());
    const Eigen::Array2f reach = (A.col(0).array().abs() + A.col(1).array().abs()) * half;
    return centre.x() - reach.x() >= 0.0F && centre.y() - reach.y() >= 0.0F &&
           centre.x() + reach.x() < static_cast<float>(image.width - 1) &&
           centre.y() + reach.y() < static_cast<float>(image.height - 1);
}

bool PatchAligner::step(const PatchTemplate& patch, const PatchTemplate::Level& level, bool affine, const float* sums,
                        Found& found, float& length) const {
    const float gain = sums[2] / level.contrast;
    const float energy = sums[1] - sums[0] * sums[0] / window_.weight_sum();
    if (!(gain > kMinGain && gain < kMaxGain && energy > 0.0F)) {
        return false;
    }
    found.correlation = sums[2] / std::sqrt(level.contrast * energy);
    Eigen::Vector2f d;
    if (affine) {
        // From the patch's centre to the anchor.
        const Eigen::Vector2f u = sums[3] * level.offset + Eigen::Vector2f(sums[5], sums[6]);
        const Eigen::Vector2f v = sums[4] * level.offset + Eigen::Vector2f(sums[7], sums[8]);
        PatchTemplate::Descent right;
        right << sums[3], sums[4], u, v;
        right -= sums[0] * level.by_one + sums[2] * level.by_grey;
        const PatchTemplate::Descent delta = patch.inverse6 * right / gain;
        if (!(delta.tail<4>().cwiseAbs().maxCoeff() < kMaxAffineStep)) {
            return false;
        }
        Eigen::Matrix2f change;
        change << 1.0F + delta[2], delta[3], delta[4], 1.0F + delta[5];
        found.A = found.A * change.inverse();
        d = delta.head<2>();
    } else {
        const Eigen::Vector2f right =
            Eigen::Vector2f(sums[3], sums[4]) - sums[0] * level.by_one.head<2>() - sums[2] * level.by_grey.head<2>();
        d = level.inverse2 * right / gain;
    }
    found.at -= found.A * d;
    length = d.norm();
    return true;
}

Status PatchAligner::align_level(const PatchTemplate& patch, const RowPairs& image, int l, bool affine,
                                 float epsilon_px, bool by_rate, Found& found) const {
    const PatchTemplate::Level& level = patch.levels[static_cast<std::size_t>(l)];
    const Eigen::Vector2f start = found.at;
    const float reach = 0.5F * static_cast<float>(window_.side());
    float before = 0.0F;
    for (int k = 0; k < max_iterations_; ++k) {
        const Eigen::Vector2f centre = found.at + found.A * level.offset;
        if (!covers(image, centre, found.A)) {
            return Status::kNotFound;
        }
        float sums[kMostSums];
        if (affine) {
            accumulate<Sums::kAffine>(image, window_, centre, found.A, planes(patch, l), sums);
        } else {
            accumulate<Sums::kPosition>(image, window_, centre, found.A, planes(patch, l), sums);
        }
        float length = 0.0F;
        if (!step(patch, level, affine, sums, found, length)) {
            return Status::kDegenerate;
        }
        // A step beyond the window means that the linearization has nothing to do with the image.
        if (!((found.at - start).squaredNorm() < reach * reach)) {
            return Status::kDegenerate;
        }
        // With rate r = length / before, the steps to come add up to length r / (1 - r). Not used for tracking itself:
        // A settles later than the position, and stopping early costs precision.
        const bool nearly_there = by_rate && length < 0.5F * before && length * length < epsilon_px * (before - length);
        if (length < epsilon_px || nearly_there) {
            break;
        }
        before = length;
    }
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
        const double scale = static_cast<double>(1 << l);
        const float wanted = std::max(epsilon_px_, options.enough_px);
        Found found{(refined.uv / scale).cast<float>(), refined.A};
        const Status status =
            align_level(patch, image.pairs(l), l, options.affine && l == 0,
                        last ? wanted : std::max(wanted, kCoarseEpsilonPx), wanted > epsilon_px_, found);
        if (ok(status)) {
            refined.A = found.A;
            refined.uv = found.at.cast<double>() * scale;
            value = found.correlation;
        } else if (last) {
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
    if (!level.valid || !covers(image.pairs(l), centre, pose.A)) {
        return -1.0F;
    }
    float sums[3];
    accumulate<Sums::kCorrelation>(image.pairs(l), window_, centre, pose.A, planes(patch, l), sums);
    const float energy = sums[1] - sums[0] * sums[0] / window_.weight_sum();
    if (!(energy > 0.25F * PatchWindow::kMinVariance * window_.weight_sum())) {
        return -1.0F;
    }
    return sums[2] / std::sqrt(level.contrast * energy);
}

}  // namespace facet
