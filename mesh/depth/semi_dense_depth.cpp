// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/depth/semi_dense_depth.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace facet {
namespace {

constexpr int kPixelStep = 2;     // px between pixels that are looked at in a square
constexpr double kSigmas = 3.0;   // within which neighbours agree,
constexpr double kAgreePx = 1.0;  // and what a slanted surface adds
constexpr double kMinRho = 0.02;  // 1/m: what is farther is no depth
constexpr int kMinAgreeing = 2;   // of the eight squares around a match
// Least change of grey along the epipolar line of a pixel to be matched (1/px).
constexpr float kMinGradient = 4.0F;
// Nothing nearer is searched for (m).
constexpr double kMinDepth_m = 0.6;

}  // namespace

Status SemiDenseDepth::configure(const StereoRig& rig, int square_px, int per_frame) {
    squares_ = next_ = 0;
    has_begun_ = false;
    const CameraIntrinsics& left = rig.left.intrinsics();
    const CameraIntrinsics& right = rig.right.intrinsics();
    matcher_.configure(rig);
    FACET_TRY(left_.configure(left.width, left.height, 1));
    FACET_TRY(right_.configure(right.width, right.height, 1));
    counters_ = {};
    side_ = square_px;
    per_frame_ = per_frame;
    while ((left.width / side_) * (left.height / side_) > kMaxDepthPoints) {
        ++side_;
    }
    columns_ = left.width / side_;
    rows_ = left.height / side_;
    squares_ = next_ = columns_ * rows_;
    constexpr double kGolden = 0.6180339887498949;
    stride_ = std::max(1, static_cast<int>(kGolden * squares_));
    while (std::gcd(stride_, squares_) > 1) {
        ++stride_;
    }
    for (int i = 0; i < squares_; ++i) {
        const Eigen::Vector2i square(i % columns_, i / columns_);
        const Eigen::Vector2d middle = (square.cast<double>().array() + 0.5) * side_;
        directions_[static_cast<std::size_t>(i)] = matcher_.epipolar_direction(middle);
    }
    return Status::kOk;
}

void SemiDenseDepth::begin(const KeyframeView& view, const ImageView& left, const ImageView& right) {
    has_begun_ = false;
    next_ = squares_;
    if (squares_ == 0 || view.is_exchanged || left.empty() || right.empty()) {
        return;
    }
    left_.build(left);
    right_.build(right);
    matcher_.correct(view.cameras);
    T_W_C0_ = view.T_W_C0;
    std::fill_n(found_.begin(), squares_, Square{});
    next_ = 0;
    has_begun_ = true;
    ++counters_.keyframes;
}

void SemiDenseDepth::advance(const Mesher& mesher) {
    const int end = std::min(squares_, next_ + per_frame_);
    for (; next_ < end; ++next_) {
        const auto square = static_cast<std::int64_t>(next_) * stride_ % squares_;
        look_at(static_cast<int>(square), mesher);
    }
}

/// The pixel of a square, off its border, that changes most along the epipolar line.
bool SemiDenseDepth::find_pixel(int column, int row, const Eigen::Vector2f& direction, Eigen::Vector2d& uv,
                                Eigen::Vector2f& gradient) const {
    const ImageView& image = left_.level(0);
    const int border = DepthMatcher::kReach_px + 2;
    const int u_end = std::min((column + 1) * side_, image.width - border);
    const int v_end = std::min((row + 1) * side_, image.height - border);
    float best = 2.0F * kMinGradient;  // of differences over two pixels
    bool is_found = false;
    for (int v = std::max(row * side_, border); v < v_end; v += kPixelStep) {
        const std::uint8_t* const above = image.row(v - 1);
        const std::uint8_t* const at = image.row(v);
        const std::uint8_t* const below = image.row(v + 1);
        for (int u = std::max(column * side_, border); u < u_end; u += kPixelStep) {
            const Eigen::Vector2f change(static_cast<float>(at[u + 1] - at[u - 1]),
                                         static_cast<float>(below[u] - above[u]));
            const float along = std::abs(change.dot(direction));
            if (along > best) {
                best = along;
                uv = {u, v};
                gradient = 0.5F * change;
                is_found = true;
            }
        }
    }
    return is_found;
}

void SemiDenseDepth::look_at(int square, const Mesher& mesher) {
    const Eigen::Vector2f& direction = directions_[static_cast<std::size_t>(square)];
    Eigen::Vector2d uv;
    Eigen::Vector2f gradient;
    if (!find_pixel(square % columns_, square / columns_, direction, uv, gradient)) {
        ++counters_.untextured;
        return;
    }
    DepthMatcher::Ray ray;
    DepthMatch match;
    DepthVerdict verdict = DepthVerdict::kOutside;
    Eigen::Vector2d xy;
    if (ok(matcher_.ray_of(uv, ray, xy))) {
        verdict = matcher_.match(left_.pairs(0), right_.pairs(0), ray, gradient,
                                 matcher_.range_about(mesher, xy, kMinDepth_m), match);
    }
    ++counters_.verdicts[static_cast<std::size_t>(verdict)];
    if (verdict == DepthVerdict::kMatched) {
        found_[static_cast<std::size_t>(square)] = {match.xy.cast<float>(), static_cast<float>(match.inverse_depth),
                                                    static_cast<float>(match.sigma), static_cast<float>(match.per_px)};
    }
}

/// How many of the squares around one have a match at its depth.
int SemiDenseDepth::agreeing(int column, int row) const {
    const Square& own = found_[static_cast<std::size_t>(row * columns_ + column)];
    int count = 0;
    for (int r = std::max(0, row - 1); r <= std::min(rows_ - 1, row + 1); ++r) {
        for (int c = std::max(0, column - 1); c <= std::min(columns_ - 1, column + 1); ++c) {
            const Square& other = found_[static_cast<std::size_t>(r * columns_ + c)];
            const double apart = static_cast<double>(std::abs(other.inverse_depth - own.inverse_depth));
            const double limit =
                kSigmas * std::hypot(static_cast<double>(own.sigma), static_cast<double>(other.sigma)) +
                kAgreePx * static_cast<double>(own.per_px);
            count += (r != row || c != column) && other.inverse_depth > 0.0F && apart <= limit ? 1 : 0;
        }
    }
    return count;
}

std::span<const DepthPoint> SemiDenseDepth::take() {
    points_.clear();
    if (!has_begun_) {
        return {};
    }
    has_begun_ = false;
    counters_.unfinished += is_busy() ? 1 : 0;
    next_ = squares_;
    for (int i = 0; i < squares_; ++i) {
        const Square& s = found_[static_cast<std::size_t>(i)];
        const auto rho = static_cast<double>(s.inverse_depth);
        if (rho < kMinRho) {
            continue;
        }
        if (agreeing(i % columns_, i / columns_) < kMinAgreeing) {
            ++counters_.lonely;
            continue;
        }
        const Eigen::Vector3d ray = s.xy.cast<double>().homogeneous();
        points_.push_back({T_W_C0_ * (ray / rho), ray.norm() * static_cast<double>(s.sigma) / (rho * rho)});
    }
    counters_.points += points_.size();
    return {points_.data(), points_.size()};
}

}  // namespace facet
