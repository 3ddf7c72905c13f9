// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/stereo_matcher.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace facet {
namespace {

constexpr int kSearchLevel = 1;
constexpr double kSearchStepPx = 2.0;  // along the curve, level 0 pixels
constexpr int kMaxSteps = 400;
constexpr float kMinSearchCorrelation = 0.7F;
constexpr float kMinMatchCorrelation = 0.8F;
constexpr double kDistinctPx = 8.0;   // places farther apart than this are different ones
constexpr float kUniqueness = 0.7F;   // (1 - best + slack) / (1 - second + slack) must stay below
constexpr float kSlack = 0.03F;       // what noise and slant take from a true match
constexpr float kRivalMargin = 0.4F;  // a sample this much worse than the best cannot have a rival peak beside it

}  // namespace

Status StereoMatcher::configure(const FrontendConfig& config, const StereoRig& rig) {
    config_ = config;
    geometry_.configure(rig);
    FACET_TRY(aligner_.configure(config.window_px, config.pyramid_levels, FrontendConfig::kLkIterations,
                                 FrontendConfig::kLkEpsilon_px));
    aligner_.allocate(patch_);
    aligner_.allocate(back_);
    scan_.configure(config.window_px);
    scores_.assign(kMaxSteps, 0.0F);
    return Status::kOk;
}

bool StereoMatcher::place(const Ray& ray, double inverse_depth, PatchPose& pose) const {
    return ok(geometry_.point_at(ray, inverse_depth, pose.uv, pose.A));
}

float StereoMatcher::score_at(const ImagePyramid& right, const Ray& ray, double inverse_depth) const {
    PatchPose pose;
    return place(ray, inverse_depth, pose) ? aligner_.correlate(patch_, right, kSearchLevel, pose) : -1.0F;
}

void StereoMatcher::score_curve(const ImagePyramid& left, const ImagePyramid& right, const Ray& ray, double step,
                                int steps) {
    const float scale = 1.0F / static_cast<float>(1 << kSearchLevel);
    PatchPose first;
    bool has_first = place(ray, 0.0, first);
    for (int begin = 0; begin < steps; begin += CurveStretch::kMaxPlaces) {
        const int count = std::min(CurveStretch::kMaxPlaces, steps - begin);
        PatchPose middle;
        PatchPose last;
        const bool has_middle = place(ray, step * (begin + 0.5 * count), middle);
        const bool has_last = place(ray, step * (begin + count), last);
        const CurveStretch stretch{scale * first.uv.cast<float>(), scale * middle.uv.cast<float>(),
                                   scale * last.uv.cast<float>(), middle.A, count};
        if (has_first && has_middle && has_last && EpipolarScan::suits(stretch)) {
            scan_.correlate(left.pairs(kSearchLevel), scale * ray.uv.cast<float>(), right.pairs(kSearchLevel), stretch,
                            scores_.data() + begin);
        } else {
            for (int i = begin; i < begin + count; ++i) {
                scores_[static_cast<std::size_t>(i)] = score_at(right, ray, step * i);
            }
        }
        first = last;
        has_first = has_last;
    }
}

float StereoMatcher::peak(const ImagePyramid& right, const Ray& ray, double step, int i, double& inverse_depth) const {
    float top = -1.0F;
    for (const double part : {0.0, -0.5, -0.25, 0.25, 0.5}) {
        const double rho = std::max(0.0, step * (i + part));
        const float score = score_at(right, ray, rho);
        if (score > top) {
            top = score;
            inverse_depth = rho;
        }
    }
    return top;
}

bool StereoMatcher::is_unique(const ImagePyramid& right, const Ray& ray, double step, std::span<const float> scores,
                              int best, float best_score, int apart) const {
    const int steps = static_cast<int>(scores.size());
    const float least = scores[static_cast<std::size_t>(best)] - kRivalMargin;
    for (int i = 0; i < steps; ++i) {
        const std::size_t k = static_cast<std::size_t>(i);
        const bool local_top = (i == 0 || scores[k] >= scores[k - 1]) && (i + 1 == steps || scores[k] >= scores[k + 1]);
        if (std::abs(i - best) < apart || !local_top || scores[k] < least) {
            continue;
        }
        double ignored = 0.0;
        if (1.0F - best_score + kSlack > kUniqueness * (1.0F - peak(right, ray, step, i, ignored) + kSlack)) {
            return false;
        }
    }
    return true;
}

Status StereoMatcher::search(const ImagePyramid& left, const ImagePyramid& right, const Ray& ray,
                             double& inverse_depth) {
    const double nearest = 1.0 / config_.min_depth_m;
    PatchPose first;
    PatchPose last;
    if (!patch_.levels[kSearchLevel].valid || !place(ray, 0.0, first) || !place(ray, nearest, last)) {
        return Status::kNotFound;
    }
    const double length = (last.uv - first.uv).norm();
    const int steps = std::clamp(static_cast<int>(std::ceil(length / kSearchStepPx)) + 1, 3, kMaxSteps);
    const double step = nearest / (steps - 1);
    score_curve(left, right, ray, step, steps);
    const std::span<const float> scores(scores_.data(), static_cast<std::size_t>(steps));
    const int best = static_cast<int>(std::max_element(scores.begin(), scores.end()) - scores.begin());
    if (scores[static_cast<std::size_t>(best)] < kMinSearchCorrelation) {
        return Status::kNotFound;
    }
    double rho = 0.0;
    const float best_score = peak(right, ray, step, best, rho);
    const int apart = std::max(1, static_cast<int>(kDistinctPx * (steps - 1) / std::max(length, 1.0)));
    if (!is_unique(right, ray, step, scores, best, best_score, apart)) {
        return Status::kDegenerate;
    }
    inverse_depth = rho;
    return Status::kOk;
}

Status StereoMatcher::refine(const ImagePyramid& left, const ImagePyramid& right, const Ray& ray, double inverse_depth,
                             StereoMatch& match) {
    PatchPose pose;
    if (!place(ray, inverse_depth, pose)) {
        return Status::kNotFound;
    }
    AlignOptions options;
    options.coarsest = 1;
    options.min_correlation = kMinMatchCorrelation;
    options.affine = true;
    float correlation = 0.0F;
    FACET_TRY(aligner_.align(patch_, right, options, pose, correlation));
    if (!geometry_.in_right_image(pose.uv, 1.0) || !geometry_.in_right_lens(pose.uv, aligner_.border_px())) {
        return Status::kNotFound;
    }
    EpipolarGeometry::Place place;
    FACET_TRY(geometry_.compare(ray, pose.uv, place));
    const bool is_on_line =
        place.off_px < std::hypot(FrontendConfig::kStereoEpipolar_px, kLineSigmas * place.off_sigma_px);
    if (!is_on_line || !(place.inverse_depth > 1e-4 && place.inverse_depth < 1.0 / config_.min_depth_m)) {
        return Status::kDegenerate;
    }

    FACET_TRY(aligner_.extract(right, pose.uv, {0, false}, back_));
    PatchPose back{pose.A.inverse(), ray.uv};
    const AlignOptions back_options{
        .coarsest = 0,
        .enough_px = PatchAligner::kCheckPrecision * static_cast<float>(FrontendConfig::kForwardBackward_px)};
    FACET_TRY(aligner_.align(back_, left, back_options, back, correlation));
    if (!((back.uv - ray.uv).norm() < FrontendConfig::kForwardBackward_px)) {
        return Status::kDegenerate;
    }
    match = {pose.uv, place.given_xy, place.inverse_depth, ray.given_xy.homogeneous() / place.inverse_depth};
    return Status::kOk;
}

Status StereoMatcher::match(const ImagePyramid& left, const ImagePyramid& right, const Eigen::Vector2d& left_uv,
                            double known_inverse_depth, StereoMatch& match) {
    Ray ray;
    FACET_TRY(geometry_.ray_of(left_uv, ray));
    FACET_TRY(aligner_.extract(left, left_uv, {1, true}, patch_));
    if (known_inverse_depth >= 0.0 && ok(refine(left, right, ray, known_inverse_depth, match))) {
        return Status::kOk;
    }
    double inverse_depth = 0.0;
    FACET_TRY(search(left, right, ray, inverse_depth));
    return refine(left, right, ray, inverse_depth, match);
}

}  // namespace facet
