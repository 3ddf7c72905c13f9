// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/volume/surface_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "platform/base/assert.h"
#include "platform/base/image_copy.h"

namespace facet {
namespace {

constexpr int kMostSquares = 32768;
constexpr double kResolvedStep = 0.5;  // m: where it is less than a pixel of disparity, nothing is measured

bool is_finite(const Se3& T) { return T.p.allFinite() && T.q.coeffs().allFinite(); }

}  // namespace

Status SurfaceMap::configure(const MapConfig& config, const StereoRig& rig) {
    FACET_TRY(config.validate());
    const CameraIntrinsics& left = rig.left.intrinsics();
    const CameraIntrinsics& right = rig.right.intrinsics();
    FACET_TRY(own_left_.configure(left.width, left.height, 1));
    FACET_TRY(other_left_.configure(left.width, left.height, 1));
    FACET_TRY(right_.configure(right.width, right.height, 1));
    config_ = config;
    int side = config.square_px;
    while ((left.width / side) * (left.height / side) > kMostSquares) {
        ++side;
    }
    sampler_ = std::make_unique<DepthSampler>(rig, side);
    growth_ = std::make_unique<DepthGrowth>(*sampler_);
    layout_ = {side, sampler_->columns(), sampler_->rows(), sampler_->per_px()};
    raster_ = std::make_unique<SquareRaster>(rig.left, side, layout_.columns, layout_.rows);
    bare_ = std::make_unique<BareSurfaces>(*raster_, layout_);
    TsdfOptions options;
    options.max_depth_m = std::sqrt(kResolvedStep / layout_.per_px);
    options.max_blocks = static_cast<std::size_t>(config.max_blocks);
    volume_ = std::make_unique<TsdfVolume>(options);
    piece_ = std::make_unique<SurfacePiece>();
    const auto squares = static_cast<std::size_t>(layout_.count());
    for (View& view : views_) {
        view.left.resize(static_cast<std::size_t>(left.width) * static_cast<std::size_t>(left.height));
        view.right.resize(static_cast<std::size_t>(right.width) * static_cast<std::size_t>(right.height));
    }
    left_size_ = {left.width, left.height};
    right_size_ = {right.width, right.height};
    samples_.assign(squares, {});
    patches_.assign(squares, {});
    depths_.reserve(squares);
    counters_ = {};
    resets_ = 0;
    restart();
    return Status::kOk;
}

/// Everything is forgotten.
void SurfaceMap::restart() {
    volume_->clear();
    oldest_ = count_ = 0;
    stage_ = Stage::kIdle;
    next_piece_ = round_left_ = 0;
}

void SurfaceMap::add(const KeyframeView& seen, std::uint32_t resets, const ImageView& left, const ImageView& right) {
    if (resets != resets_) {
        extract_all();
        restart();
        resets_ = resets;
        ++counters_.restarts;
    }
    follow(seen);
    const auto has_size = [](const ImageView& image, const Eigen::Vector2i& size) {
        return image.width == size.x() && image.height == size.y();
    };
    if (seen.is_exchanged || !has_size(left, left_size_) || !has_size(right, right_size_) || !is_finite(seen.T_W_C0) ||
        !shows_enough(seen.T_W_C0) || !make_place()) {
        ++counters_.skipped;
        return;
    }
    take(seen, left, right);
}

/// Whether a view shows enough that the last one taken does not: asked when there is not much room left, and the more,
/// the less there is.
bool SurfaceMap::shows_enough(const Se3& T_W_C0) {
    constexpr double kTypicalDepth = 2.5;  // m: what moves by it turns what is seen by a radian
    constexpr double kMore = 0.04;         // rad, of both, for each view that waits
    constexpr std::size_t kMany = 12;      // beyond so many
    std::size_t waiting = 0;
    for (std::size_t i = 0; i < count_; ++i) {
        waiting += view(i).fate == Fate::kWaits ? 1 : 0;
    }
    if (waiting <= kMany) {
        return true;
    }
    const Se3 T_last_C = view(count_ - 1).T_W_C0.inverse() * T_W_C0;
    const double change = so3_log(T_last_C.q).norm() + T_last_C.p.norm() / kTypicalDepth;
    return change >= kMore * static_cast<double>(waiting - kMany);
}

/// Room for another view. @return whether there is: none while the oldest one waits, or is being compared with
bool SurfaceMap::make_place() {
    if (count_ < kViews) {
        return true;
    }
    View& first = view(0);
    const bool is_read = stage_ == Stage::kCompare && std::ranges::any_of(partners_, [&](const Partner& partner) {
                             return partner.slot == oldest_;
                         });
    if (first.fate == Fate::kWaits || is_read) {
        return false;
    }
    if (first.fate == Fate::kIntegrated) {
        settle(first);
    }
    oldest_ = (oldest_ + 1) % kViews;
    --count_;
    return true;
}

/// Poses as the window has them now.
void SurfaceMap::follow(const KeyframeView& seen) {
    for (std::size_t i = 0; i < count_; ++i) {
        View& known = view(i);
        if (!known.is_in_window) {
            continue;
        }
        const auto* const pose = std::find_if(seen.keyframes.begin(), seen.keyframes.end(), [&](const KeyframePose& p) {
            return p.stamp == known.stamp && is_finite(p.T_W_C0);
        });
        known.is_in_window = pose != seen.keyframes.end();
        if (known.is_in_window) {
            known.T_W_C0 = pose->T_W_C0;
        } else if (known.fate == Fate::kIntegrated) {
            settle(known);
        }
    }
}

/// Its pose will not change any more.
void SurfaceMap::settle(View& known) {
    const double moved = (known.T_W_C0.p - known.T_integrated.p).norm();
    known.fate = Fate::kSettled;
    ++counters_.settled;
    counters_.moved_m += moved;
    counters_.moved_most_m = std::max(counters_.moved_most_m, moved);
}

void SurfaceMap::take(const KeyframeView& seen, const ImageView& left, const ImageView& right) {
    View& taken = view(count_++);
    taken.stamp = seen.stamp;
    taken.T_W_C0 = seen.T_W_C0;
    taken.cameras = seen.cameras;
    taken.is_in_window = true;
    taken.fate = Fate::kWaits;
    copy_pixels(left, taken.left.data());
    copy_pixels(right, taken.right.data());
    taken.seeds.clear();
    add_seeds({seen.landmarks.data(), seen.landmarks.size()}, taken);
    add_seeds({seen.surface.data(), seen.surface.size()}, taken);
    ++counters_.keyframes;
}

/// Depths that the keyframe has of some squares.
void SurfaceMap::add_seeds(std::span<const LandmarkSnapshot> landmarks, View& taken) const {
    for (const LandmarkSnapshot& landmark : landmarks) {
        const Eigen::Vector2f place = (landmark.left_px.array() + 0.5F) / static_cast<float>(layout_.side_px);
        if (landmark.is_tracked && landmark.depth_m > 0.0F && place.x() >= 0.0F && place.y() >= 0.0F &&
            place.x() < static_cast<float>(layout_.columns) && place.y() < static_cast<float>(layout_.rows) &&
            !taken.seeds.full()) {
            const int square = static_cast<int>(place.y()) * layout_.columns + static_cast<int>(place.x());
            taken.seeds.push_back({square, 1.0F / landmark.depth_m});
        }
    }
}

}  // namespace facet
