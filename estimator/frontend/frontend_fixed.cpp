// SPDX-License-Identifier: BSD-2-Clause
// Tracks of what is fixed to the vehicle: an emitter's dots, guards, legs, dirt on a window.
#include <algorithm>
#include <cmath>
#include <optional>

#include "estimator/frontend/frontend_impl.h"

namespace facet {
namespace {

// A track is watched for this long.
constexpr double kWatch_s = 1.5;
// One is judged once the vehicle has turned by so many pixels: less may be a gyroscope's bias. Of an outlier, which is
// dropped long before, less says enough if it happens at one place again and again.
constexpr double kTurned_px = 30.0;
constexpr double kTurnedOutlier_px = 5.0;
// One that has gone less than this share of it is fixed: an emitter's dots go by what their depths differ. One that has
// gone at least the other share is of the world.
constexpr double kFixedShare = 0.2;
constexpr double kMovingShare = 0.5;
// The gyroscope is believed if so many tracks, and one for so many that are fixed, go as it says; or if nearly all are
// fixed while the accelerometer contradicts the images as well: of one fault and two, it is the one.
constexpr int kFewestWitnesses = 8;
constexpr int kFixedPerWitness = 12;
// Dots that are at their places after a turn of so many pixels move with the vehicle: others have gone farther than
// is_dot() looks, and than depth moves an emitter's. A dot at just the place of another is rare.
constexpr double kTurnedDots_px = 12.0;
constexpr std::size_t kFewestDots = 8;

}  // namespace

void Frontend::Impl::watch(Track& track) const {
    track.watched_since = sights[0].stamp;
    track.watched_uv = track.pose.uv;
    track.watched_ray_B0 = sights[0].q_B0_B_as_read * (rig.T_B_C0.q * track.xy.homogeneous());
}

std::optional<double> Frontend::Impl::share_of_turn(const Track& track, double least_px) const {
    const Eigen::Vector3d ray = (sights[0].q_B0_B_as_read * rig.T_B_C0.q).conjugate() * track.watched_ray_B0;
    Eigen::Vector2d turned_uv;
    if (!(ray.z() > 0.0) || !ok(rig.left.project(ray, turned_uv))) {
        return std::nullopt;
    }
    const double turned_px = (turned_uv - track.watched_uv).norm();
    const double gone_px = (track.pose.uv - track.watched_uv).norm();
    return turned_px < least_px ? std::nullopt : std::optional(gone_px / turned_px);
}

void Frontend::Impl::judge_fixed(Track& track) const {
    if (const std::optional<double> share = share_of_turn(track, kTurned_px)) {
        track.is_fixed = *share < kFixedShare;
        track.goes_with_world = *share > kMovingShare;
        watch(track);
    } else if ((sights[0].stamp - track.watched_since).seconds() > kWatch_s) {
        watch(track);
    }
}

void Frontend::Impl::suspect_outlier(const Track& track) {
    const std::optional<double> share = share_of_turn(track, kTurnedOutlier_px);
    if (track.is_fixed || (share && *share < kFixedShare)) {
        mask.suspect(track.pose.uv, sights[0].stamp);
    }
}

bool Frontend::Impl::shows_dots(const ImageView& image, const FrameHints& hints) {
    if (takes_out_dots || hints.is_starting || !hints.is_contradicted) {
        return false;
    }
    const Sight& now = sights[0];
    const double turned_px = rig.left.focal_px() * dots_then.q_B0_B.angularDistance(now.q_B0_B_as_read);
    const bool is_fresh = (now.stamp - dots_then.stamp).seconds() < kWatch_s && dots_then.places.size() >= kFewestDots;
    if (is_fresh && turned_px < kTurnedDots_px) {
        return false;
    }
    const ImageView opened = dots.open(image);
    const auto is_dot = [&](const Eigen::Vector2d& uv) { return DotFilter::is_dot(image, opened, uv); };
    const auto stayed = std::count_if(dots_then.places.begin(), dots_then.places.end(), is_dot);
    if (is_fresh && 2 * stayed > static_cast<std::ptrdiff_t>(dots_then.places.size())) {
        return true;
    }
    dots_then = {now.stamp, now.q_B0_B_as_read, {}};
    for (const Track& track : tracks) {
        if (track.unseen == 0 && is_dot(track.pose.uv)) {
            dots_then.places.push_back(track.pose.uv);
        }
    }
    if (2 * dots_then.places.size() < observed()) {
        dots_then.places.clear();
    }
    return false;
}

void Frontend::Impl::leave_out_fixed(const FrameHints& hints, FrontendOutput& output) {
    int fixed = 0;
    int moving = 0;
    for (std::size_t i = tracks.size(); i-- > 0;) {
        Track& track = tracks[i];
        if (mask.is_drawn(track.pose.uv)) {
            remove(i);
            ++output.lost;
        } else if (hints.is_starting) {
            watch(track);
        } else if (track.unseen == 0) {
            judge_fixed(track);
            fixed += track.is_fixed ? 1 : 0;
            moving += track.goes_with_world ? 1 : 0;
        }
    }
    const bool is_witnessed = moving >= kFewestWitnesses && kFixedPerWitness * moving >= fixed;
    const bool is_alone = hints.replaces_both && 2 * fixed > static_cast<int>(tracks.size());
    if (!hints.is_contradicted || fixed == 0 || !(is_witnessed || is_alone)) {
        return;
    }
    for (std::size_t i = tracks.size(); i-- > 0;) {
        if (tracks[i].is_fixed) {
            mask.cover(tracks[i].pose.uv, sights[0].stamp);
            remove(i);
            ++output.outliers;
            ++output.lost;
        }
    }
}

}  // namespace facet
