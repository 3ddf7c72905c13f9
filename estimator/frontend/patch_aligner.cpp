// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/patch_aligner.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

namespace facet {
namespace {

using ConstArray = Eigen::Map<const Eigen::ArrayXf>;

constexpr float kMinVariance = 4.0F;       // grey levels^2: below, a patch is noise
constexpr float kMinCurvature = 2.0F;      // least eigenvalue of the normal matrix of the position, per pixel
constexpr float kMinGain = 0.15F;
constexpr float kMaxGain = 6.0F;
constexpr float kWeightSigma = 0.55F;      // of the window's half width
constexpr float kMaxAffineStep = 0.5F;

}  // namespace

Status PatchAligner::configure(int window_px, int levels, int max_iterations, double epsilon_px) {
    if (window_px < 5 || window_px % 2 == 0 || levels < 1 || levels > ImagePyramid::kMaxLevels) {
        return Status::kInvalidArgument;
    }
    window_ = window_px;
    area_ = window_px * window_px;
    levels_ = levels;
    max_iterations_ = max_iterations;
    epsilon_px_ = static_cast<float>(epsilon_px);
    weights_.resize(area_);
    grid_x_.resize(area_);
    grid_y_.resize(area_);
    sampled_.resize(area_);
    residual_.resize(area_);
    const int half = window_px / 2;
    for (int i = 0; i < area_; ++i) {
        grid_x_[i] = static_cast<float>(i % window_px - half);
        grid_y_[i] = static_cast<float>(i / window_px - half);
    }
    const float sigma = kWeightSigma * static_cast<float>(half + 1);
    weights_ = (-(grid_x_.square() + grid_y_.square()) / (2.0F * sigma * sigma)).exp();
    weights_ *= static_cast<float>(area_) / weights_.sum();
    return Status::kOk;
}

void PatchAligner::allocate(PatchTemplate& patch) const {
    patch.pixels.assign(static_cast<std::size_t>(3 * levels_ * area_), 0.0F);
}

Status PatchAligner::extract(const ImagePyramid& image, const Eigen::Vector2d& uv, PatchTemplate& patch) const {
    const int half = window_ / 2;
    const float inv_area = 1.0F / static_cast<float>(area_);
    for (int l = 0; l < levels_; ++l) {
        const ImageView& view = image.level(l);
        PatchTemplate::Level& level = patch.levels[static_cast<std::size_t>(l)];
        const Eigen::Vector2d at = uv / static_cast<double>(1 << l);
        const int cu = static_cast<int>(std::lround(at.x()));
        const int cv = static_cast<int>(std::lround(at.y()));
        level.valid = cu - half >= 1 && cv - half >= 1 && cu + half + 1 < view.width && cv + half + 1 < view.height;
        if (!level.valid) {
            continue;
        }
        level.offset = (Eigen::Vector2d(cu, cv) - at).cast<float>();
        float* grey = patch.pixels.data() + static_cast<std::ptrdiff_t>(l * 3 * area_);
        float* du = grey + area_;
        float* dv = du + area_;
        for (int y = 0, i = 0; y < window_; ++y) {
            const std::uint8_t* row = view.row(cv - half + y) + (cu - half);
            const std::uint8_t* above = row - view.stride;
            const std::uint8_t* below = row + view.stride;
            for (int x = 0; x < window_; ++x, ++i) {
                grey[i] = row[x];
                du[i] = 0.5F * static_cast<float>(row[x + 1] - row[x - 1]);
                dv[i] = 0.5F * static_cast<float>(below[x] - above[x]);
            }
        }
        Eigen::Map<Eigen::ArrayXf> t(grey, area_);
        const ConstArray gu(du, area_);
        const ConstArray gv(dv, area_);
        t -= (weights_ * t).sum() * inv_area;
        level.contrast = (weights_ * t.square()).sum();
        if (level.contrast < kMinVariance * static_cast<float>(area_)) {
            level.valid = false;
            continue;
        }
        // J = P [gu gv gu*x gu*y gv*x gv*y]; P removes the components along 1 and T.
        Eigen::Matrix<float, 6, 1> along_one;
        Eigen::Matrix<float, 6, 1> along_t;
        const float ox = level.offset.x();
        const float oy = level.offset.y();
        const auto column = [&](int k) -> Eigen::ArrayXf {
            switch (k) {
                case 0: return gu;
                case 1: return gv;
                case 2: return gu * (grid_x_ + ox);
                case 3: return gu * (grid_y_ + oy);
                case 4: return gv * (grid_x_ + ox);
                default: return gv * (grid_y_ + oy);
            }
        };
        const int unknowns = l == 0 ? 6 : 2;
        for (int a = 0; a < unknowns; ++a) {
            const Eigen::ArrayXf ca = weights_ * column(a);
            along_one[a] = ca.sum();
            along_t[a] = (ca * t).sum();
            for (int b = 0; b <= a; ++b) {
                level.normal(a, b) = (ca * column(b)).sum();
            }
        }
        for (int a = 0; a < unknowns; ++a) {
            for (int b = 0; b <= a; ++b) {
                level.normal(a, b) -= along_one[a] * along_one[b] * inv_area + along_t[a] * along_t[b] / level.contrast;
                level.normal(b, a) = level.normal(a, b);
            }
        }
        const float trace = level.normal(0, 0) + level.normal(1, 1);
        const float det = level.normal(0, 0) * level.normal(1, 1) - level.normal(0, 1) * level.normal(0, 1);
        const float least = 0.5F * (trace - std::sqrt(std::max(0.0F, trace * trace - 4.0F * det)));
        level.valid = least > kMinCurvature * static_cast<float>(area_);
    }
    const bool inside = uv.x() >= border_px() && uv.y() >= border_px() && uv.x() <= image.level(0).width - 1 - border_px() &&
                        uv.y() <= image.level(0).height - 1 - border_px();
    if (patch.levels[0].valid) {
        return Status::kOk;
    }
    return inside ? Status::kDegenerate : Status::kNotFound;
}

bool PatchAligner::sample(const ImageView& image, const Eigen::Vector2f& centre, const Eigen::Matrix2f& A, float* out) const {
    const float half = static_cast<float>(window_ / 2);
    const Eigen::Array2f reach = (A.col(0).array().abs() + A.col(1).array().abs()) * half;
    const bool inside = centre.x() - reach.x() >= 0.0F && centre.y() - reach.y() >= 0.0F &&
                        centre.x() + reach.x() < static_cast<float>(image.width - 1) &&
                        centre.y() + reach.y() < static_cast<float>(image.height - 1);
    if (!inside) {
        return false;
    }
    const float step_u = A(0, 0);
    const float step_v = A(1, 0);
    for (int y = 0; y < window_; ++y) {
        const float dy = static_cast<float>(y) - half;
        const float u0 = centre.x() + A(0, 1) * dy - step_u * half;
        const float v0 = centre.y() + A(1, 1) * dy - step_v * half;
        for (int x = 0; x < window_; ++x) {
            const float u = std::max(0.0F, u0 + step_u * static_cast<float>(x));
            const float v = std::max(0.0F, v0 + step_v * static_cast<float>(x));
            const int iu = static_cast<int>(u);
            const int iv = static_cast<int>(v);
            const float fu = u - static_cast<float>(iu);
            const float fv = v - static_cast<float>(iv);
            const std::uint8_t* p = image.data + static_cast<std::ptrdiff_t>(iv) * image.stride + iu;
            const std::uint8_t* q = p + image.stride;
            const float top = static_cast<float>(p[0]) + fu * static_cast<float>(p[1] - p[0]);
            const float bottom = static_cast<float>(q[0]) + fu * static_cast<float>(q[1] - q[0]);
            *out++ = top + fv * (bottom - top);
        }
    }
    return true;
}

Status PatchAligner::align_level(const PatchTemplate& patch, const ImageView& image, int l, bool affine, PatchPose& pose,
                                 float& correlation) {
    const PatchTemplate::Level& level = patch.levels[static_cast<std::size_t>(l)];
    const float scale = 1.0F / static_cast<float>(1 << l);
    const float inv_area = 1.0F / static_cast<float>(area_);
    const ConstArray t(pixels(patch, l, 0), area_);
    const ConstArray gu(pixels(patch, l, 1), area_);
    const ConstArray gv(pixels(patch, l, 2), area_);
    Eigen::Vector2f at = (pose.uv * static_cast<double>(scale)).cast<float>();
    Eigen::Matrix2f A = pose.A;
    const Eigen::Vector2f start = at;
    const Eigen::Matrix2f inverse2 = level.normal.topLeftCorner<2, 2>().inverse();
    Eigen::LDLT<Eigen::Matrix<float, 6, 6>> normal6;
    if (affine) {
        Eigen::Matrix<float, 6, 6> damped = level.normal;
        damped.diagonal() *= 1.0F + 1e-3F;
        normal6.compute(damped);
    }
    for (int step = 0; step < max_iterations_; ++step) {
        if (!sample(image, at + A * level.offset, A, sampled_.data())) {
            return Status::kNotFound;
        }
        sampled_ -= (weights_ * sampled_).sum() * inv_area;
        const float gain = (weights_ * t * sampled_).sum() / level.contrast;
        const float energy = (weights_ * sampled_.square()).sum();
        if (!(gain > kMinGain && gain < kMaxGain)) {
            return Status::kDegenerate;
        }
        correlation = gain * std::sqrt(level.contrast / energy);
        residual_ = weights_ * (sampled_ / gain - t);
        Eigen::Vector2f d;
        if (affine) {
            Eigen::Matrix<float, 6, 1> b;
            const float ox = level.offset.x();
            const float oy = level.offset.y();
            b[0] = (gu * residual_).sum();
            b[1] = (gv * residual_).sum();
            b[2] = (gu * residual_ * grid_x_).sum() + ox * b[0];
            b[3] = (gu * residual_ * grid_y_).sum() + oy * b[0];
            b[4] = (gv * residual_ * grid_x_).sum() + ox * b[1];
            b[5] = (gv * residual_ * grid_y_).sum() + oy * b[1];
            const Eigen::Matrix<float, 6, 1> delta = normal6.solve(b);
            if (!(delta.tail<4>().cwiseAbs().maxCoeff() < kMaxAffineStep)) {
                return Status::kDegenerate;
            }
            Eigen::Matrix2f change;
            change << 1.0F + delta[2], delta[3], delta[4], 1.0F + delta[5];
            A = A * change.inverse();
            d = delta.head<2>();
        } else {
            d = inverse2 * Eigen::Vector2f((gu * residual_).sum(), (gv * residual_).sum());
        }
        at -= A * d;
        // A step beyond the window means that the linearization has nothing to do with the image.
        if (!((at - start).squaredNorm() < 0.25F * static_cast<float>(area_))) {
            return Status::kDegenerate;
        }
        if (d.squaredNorm() < epsilon_px_ * epsilon_px_) {
            break;
        }
    }
    pose.A = A;
    pose.uv = at.cast<double>() / static_cast<double>(scale);
    return Status::kOk;
}

Status PatchAligner::align(const PatchTemplate& patch, const ImagePyramid& image, const AlignOptions& options,
                           PatchPose& pose, float& correlation) {
    PatchPose refined = pose;
    float value = 0.0F;
    for (int l = std::min(options.coarsest, levels_ - 1); l >= options.finest; --l) {
        if (!patch.levels[static_cast<std::size_t>(l)].valid) {
            if (l == options.finest) {
                return Status::kDegenerate;
            }
            continue;
        }
        const bool last = l == options.finest;
        Status status = align_level(patch, image.level(l), l, false, refined, value);
        if (last && ok(status) && options.affine && l == 0) {
            status = align_level(patch, image.level(l), l, true, refined, value);
        }
        if (last && !ok(status)) {
            return status;
        }
    }
    if (value < options.min_correlation) {
        return Status::kDegenerate;
    }
    pose = refined;
    correlation = value;
    return Status::kOk;
}

float PatchAligner::correlate(const PatchTemplate& patch, const ImagePyramid& image, int l, const PatchPose& pose) {
    const PatchTemplate::Level& level = patch.levels[static_cast<std::size_t>(l)];
    const Eigen::Vector2f at = (pose.uv / static_cast<double>(1 << l)).cast<float>();
    if (!level.valid || !sample(image.level(l), at + pose.A * level.offset, pose.A, sampled_.data())) {
        return -1.0F;
    }
    sampled_ -= (weights_ * sampled_).sum() / static_cast<float>(area_);
    const float energy = (weights_ * sampled_.square()).sum();
    if (!(energy > kMinVariance * static_cast<float>(area_) * 0.25F)) {
        return -1.0F;
    }
    return (weights_ * ConstArray(pixels(patch, l, 0), area_) * sampled_).sum() / std::sqrt(level.contrast * energy);
}

}  // namespace facet
