// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/depth/depth_matcher.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "mesh/mesher.h"

namespace facet {
namespace {

// Matched back into the left image, the place must come out within this distance of the pixel (px).
constexpr double kLeftRight_px = 1.0;
// A match's distance from perfect correlation must be less than this times that of any other place.
constexpr double kUniqueness = 0.7;
constexpr float kMinCorrelation = 0.8F;  // of a match
constexpr double kSearch_px = 6.0;       // beyond the depths of a triangle's corners
constexpr int kApart = 3;                // px: places farther apart than this are different ones
constexpr float kSlack = 0.02F;          // what noise and slant take from a true match's correlation
constexpr int kBackReach = 12;           // px searched to either side on the way back
constexpr double kInterpolation = 0.1;   // px
constexpr double kBesideLine = 0.25;     // px

/// Offset in [-0.5, 0.5] of the top of a parabola through three values, the middle one the largest, from the middle.
double top_offset(float before, float at, float after) {
    const double bend = 2.0 * at - before - after;
    return bend > 1e-9 ? std::clamp(0.5 * (after - before) / bend, -0.5, 0.5) : 0.0;
}

/// The height of that top.
float top_value(float before, float at, float after) {
    const float bend = 2.0F * at - before - after;
    const float slope = after - before;
    return bend > 1e-9F ? std::min(1.0F, at + 0.125F * slope * slope / bend) : at;
}

}  // namespace

void DepthMatcher::configure(const StereoRig& rig) {
    set_rig(rig);
    scan_.configure(2 * kReach_px + 1);
    PatchWindow window;
    window.configure(2 * kReach_px + 1);
    double sum = 0.0;
    double squares = 0.0;
    for (int v = -window.half(); v <= window.half(); ++v) {
        for (int u = -window.half(); u <= window.half(); ++u) {
            const double w = static_cast<double>(window.weight(u, v));
            sum += w;
            squares += w * w;
        }
    }
    pixels_ = sum * sum / squares;
}

void DepthMatcher::set_rig(const StereoRig& rig) {
    geometry_.configure(rig);
    left_lens_.setZero();
    per_px_ = 1.0 / (rig.right.focal_px() * std::max(rig.baseline_m(), 1e-6));
}

void DepthMatcher::correct(const CameraCorrections& corrections) {
    geometry_.correct(corrections);
    left_lens_ = corrections.lens[0];
}

Status DepthMatcher::ray_of(const Eigen::Vector2d& left_uv, Ray& ray, Eigen::Vector2d& xy) const {
    FACET_TRY(geometry_.ray_of(left_uv, ray));
    xy = ray.given_xy + ray.d_xy_d_lens * left_lens_;
    return Status::kOk;
}

Eigen::Vector2f DepthMatcher::epipolar_direction(const Eigen::Vector2d& left_uv) const {
    Ray ray;
    Place far;
    Place near;
    if (!ok(geometry_.ray_of(left_uv, ray)) || !place(ray, 0.0, far) || !place(ray, 10.0 * per_px_, near)) {
        return Eigen::Vector2f::Zero();
    }
    const Eigen::Vector2f moved = (near.uv - far.uv).cast<float>();
    if (!(std::abs(near.A.determinant()) > 0.1F) || !(moved.norm() > 1e-3F)) {
        return Eigen::Vector2f::Zero();
    }
    return (near.A.inverse() * moved).normalized();
}

/// Fills scores_ at inverse depths first, first + step, ..., of which the first is seen at `begin`; false if the curve
/// is not a smooth one in the image.
bool DepthMatcher::score(const RowPairs& left, const RowPairs& right, const Ray& ray, double first, double step,
                         int places, Place begin) {
    for (int at = 0; at < places; at += CurveStretch::kMaxPlaces) {
        const int count = std::min(CurveStretch::kMaxPlaces, places - at);
        Place middle;
        Place end;
        if (!place(ray, first + step * (at + 0.5 * count), middle) || !place(ray, first + step * (at + count), end)) {
            return false;
        }
        const CurveStretch stretch{begin.uv.cast<float>(), middle.uv.cast<float>(), end.uv.cast<float>(), middle.A,
                                   count};
        if (!EpipolarScan::suits(stretch)) {
            return false;
        }
        scan_.correlate(left, ray.uv.cast<float>(), right, stretch, scores_.data() + at);
        begin = end;
    }
    return true;
}

/// Tops are compared where they are, between the places: else a repeated pattern would look unique at the one of its
/// tops that happens to lie on a place.
bool DepthMatcher::is_unique(std::span<const float> scores, int best) const {
    const int count = static_cast<int>(scores.size());
    const auto height = [&](int i) {
        const auto k = static_cast<std::size_t>(i);
        const bool is_top = i > 0 && i + 1 < count && scores[k] >= scores[k - 1] && scores[k] >= scores[k + 1];
        return is_top ? top_value(scores[k - 1], scores[k], scores[k + 1]) : scores[k];
    };
    float second = -1.0F;
    for (int i = 0; i < count; ++i) {
        if (std::abs(i - best) >= kApart) {
            second = std::max(second, height(i));
        }
    }
    return 1.0F - height(best) + kSlack <= static_cast<float>(kUniqueness) * (1.0F - second + kSlack);
}

/// Whether the place found, looked for along the curve in the left image, is the pixel.
bool DepthMatcher::leads_back(const RowPairs& left, const RowPairs& right, const Ray& ray, const Place& found,
                              const Eigen::Vector2f& along) {
    constexpr int kCount = 2 * kBackReach + 1;
    static_assert(kCount <= CurveStretch::kMaxPlaces);
    const Eigen::Matrix2f back = found.A.inverse();
    const Eigen::Vector2f step = (back * along).normalized();
    const Eigen::Vector2f first = ray.uv.cast<float>() - static_cast<float>(kBackReach) * step;
    const CurveStretch stretch{first, first + 0.5F * kCount * step, first + static_cast<float>(kCount) * step, back,
                               kCount};
    scan_.correlate(right, found.uv.cast<float>(), left, stretch, back_.data());
    const auto* const last = back_.begin() + kCount;
    const int best = static_cast<int>(std::max_element(static_cast<const float*>(back_.data()), last) - back_.begin());
    if (best == 0 || best == kCount - 1) {
        return false;
    }
    const auto at = static_cast<std::size_t>(best);
    return std::abs(best - kBackReach + top_offset(back_[at - 1], back_[at], back_[at + 1])) <= kLeftRight_px;
}

DepthRange DepthMatcher::range_about(const Mesher& mesher, const Eigen::Vector2d& xy, double min_depth_m) const {
    const double nearest = 1.0 / min_depth_m;
    DepthPrior prior;
    if (!mesher.depth_prior(xy, prior)) {
        return {0.0, nearest};
    }
    const double margin = kSearch_px * per_px();
    return {std::clamp(prior.farthest - margin, 0.0, nearest - margin),
            std::clamp(prior.nearest + margin, margin, nearest)};
}

DepthVerdict DepthMatcher::match(const RowPairs& left, const RowPairs& right, const Ray& ray,
                                 const Eigen::Vector2f& gradient, const DepthRange& range, DepthMatch& match,
                                 DepthCheck check) {
    Place far;
    Place near;
    if (!place(ray, range.farthest, far) || !place(ray, range.nearest, near)) {
        return DepthVerdict::kOutside;
    }
    const double length = (near.uv - far.uv).norm();
    const int places = std::clamp(static_cast<int>(std::ceil(length)) + 1, 5, kMaxPlaces);
    const double step = (range.nearest - range.farthest) / std::max(length, 1e-3);
    if (!score(left, right, ray, range.farthest, step, places, far)) {
        return DepthVerdict::kOutside;
    }
    const std::span<const float> scores(scores_.data(), static_cast<std::size_t>(places));
    const int best = static_cast<int>(std::max_element(scores.begin(), scores.end()) - scores.begin());
    const auto at = static_cast<std::size_t>(best);
    if (scores[at] < kMinCorrelation) {
        return DepthVerdict::kWeak;
    }
    if (best == 0 || best == places - 1 || scores[at - 1] < 0.0F || scores[at + 1] < 0.0F) {
        return DepthVerdict::kOutside;
    }
    if (!is_unique(scores, best)) {
        return DepthVerdict::kAmbiguous;
    }
    const double inverse_depth =
        range.farthest + step * (best + top_offset(scores[at - 1], scores[at], scores[at + 1]));
    Place found = near;  // near enough where a few pixels are searched, one way
    const Eigen::Vector2f along = (near.uv - far.uv).cast<float>().normalized();
    if (!(inverse_depth > 0.0)) {
        return DepthVerdict::kOutside;
    }
    if (check == DepthCheck::kBothWays) {
        if (!place(ray, inverse_depth, found)) {
            return DepthVerdict::kOutside;
        }
        if (!leads_back(left, right, ray, found, along)) {
            return DepthVerdict::kOneSided;
        }
    }
    const double bend = 2.0 * scores[at] - scores[at - 1] - scores[at + 1];
    const Eigen::Vector2f back = (found.A.inverse() * along).normalized();
    const double slope =
        std::abs((gradient.x() * back.y() - gradient.y() * back.x()) / std::max(std::abs(gradient.dot(back)), 1e-3F));
    const double variance =
        2.0 * std::max(0.0, 1.0 - static_cast<double>(scores[at])) / (pixels_ * std::max(bend, 1e-6)) +
        kInterpolation * kInterpolation + kBesideLine * kBesideLine * slope * slope;
    match.xy = ray.given_xy + ray.d_xy_d_lens * left_lens_;
    match.inverse_depth = inverse_depth;
    match.per_px = step;
    match.sigma = std::sqrt(variance) * step;
    match.correlation = scores[at];
    return DepthVerdict::kMatched;
}

}  // namespace facet
