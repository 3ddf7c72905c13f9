// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/frontend.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "estimator/frontend/frontend_impl.h"
#include "estimator/frontend/image_check.h"

namespace facet {

void Frontend::Impl::reset() {
    tracks.clear();
    dormant.clear();
    if (engine) {
        engine->reset();
    }
    policy.reset();
    has_previous = false;
    was_still = false;
    q_Bk_B.setIdentity();
    for (Sight& sight : sights) {
        sight.q_B0_B.setIdentity();
        sight.q_B0_B_as_read.setIdentity();
    }
    frame_number = next_turn = 0;
    keyframe_tracks = 0;
    corners_wait = false;
    dots_then = {};
}

void Frontend::Impl::remove(std::size_t index) {
    engine->stop(tracks[index]);
    tracks.erase(tracks.begin() + static_cast<std::ptrdiff_t>(index));
}

ImageState Frontend::Impl::judge_image(const Eigen::Quaterniond& q_Bp_B) const {
    constexpr double kTurned = 1e-3;  // rad: more than the gyroscope may err from frame to frame
    if (has_previous && q_Bp_B.vec().norm() > 0.5 * kTurned && is_same_image(left.level(0), sights[1].image.level(0))) {
        return ImageState::kFrozen;
    }
    return check_image(left.level(left.levels() - 1));
}

void Frontend::Impl::follow_and_choose(const StereoFrame& frame, const FrameHints& hints, FrontendOutput& output) {
    const bool has_right = !frame.right.empty();
    if (has_previous) {
        age_tracks();
        follow_in_turns(hints, output);
        if (2 * live() < keyframe_tracks) {
            recall(hints, output);  // most tracks were lost at once: after darkness, or behind something large
        }
        reject_mono_outliers(output);
        leave_out_fixed(hints, output);
        output.shows_dots = shows_dots(frame.left, hints);
        if (hints.wants_turn) {
            measure_turn(output);
        }
    }
    output.tracked = static_cast<int>(tracks.size());
    measure_disparity(output);
    output.is_keyframe = policy.decide(
        {frame.stamp, live(), keyframe_tracks, output.median_disparity_px, has_right, hints.wants_keyframe});
    if (output.is_keyframe) {
        if (has_previous && observed() < tracks.size()) {
            follow_rest(output);
            reject_mono_outliers(output);
            output.tracked = static_cast<int>(tracks.size());
        }
        if (has_right) {
            right.build(without_dots(frame.right));
            engine->begin_right(right);
        }
        make_keyframe(hints, has_right, output);
    }
    fill_observations(output);
    output.fixed_share = std::max(mask.found_share(frame.stamp), dots_share);
}

ImageView Frontend::Impl::without_dots(const ImageView& image) {
    if (!takes_out_dots) {
        return image;
    }
    const ImageView opened = dots.open(image);
    dots_share = DotFilter::share(image, opened);
    return opened;
}

void Frontend::Impl::begin_sight(const StereoFrame& frame, const FrameHints& hints) {
    for (std::size_t k = sights.size() - 1; k > 0; --k) {
        std::swap(sights[k], sights[k - 1]);
    }
    sights[0].q_B0_B = (sights[1].q_B0_B * hints.q_Bp_B).normalized();
    const Eigen::Quaterniond& q_as_read = hints.is_replaced ? hints.q_Bp_B_as_read : hints.q_Bp_B;
    sights[0].q_B0_B_as_read = (sights[1].q_B0_B_as_read * q_as_read).normalized();
    sights[0].stamp = frame.stamp;
    q_Bk_B = (q_Bk_B * hints.q_Bp_B).normalized();
    ++frame_number;
}

Status Frontend::Impl::process(const StereoFrame& frame, const FrameHints& hints, FrontendOutput& result) {
    const bool has_right = !frame.right.empty();
    if (!configured || !image_ok(frame.left, rig.left) || (has_right && !image_ok(frame.right, rig.right)) ||
        !(std::abs(hints.q_Bp_B.norm() - 1.0) < 1e-3)) {
        return Status::kInvalidArgument;
    }
    if (has_previous && frame.stamp <= sights[0].stamp) {
        return Status::kOutOfOrder;
    }
    if (has_corrections) {
        engine->correct(next_corrections);
        has_corrections = false;
    }
    corners_wait = false;
    has_predictions = false;
    FrontendOutput output;
    output.stamp = frame.stamp;
    begin_sight(frame, hints);
    left.build(without_dots(frame.left));
    engine->begin_frame(left);
    output.image = judge_image(hints.q_Bp_B);
    if (output.image == ImageState::kUsable) {
        follow_and_choose(frame, hints, output);
    } else {
        for (const Track& track : tracks) {
            dormant.add(track, sights[static_cast<std::size_t>(track.unseen + 1)].q_B0_B, *engine);
        }
        output.lost = static_cast<int>(tracks.size());
        tracks.clear();
    }
    has_previous = true;
    result = output;
    return Status::kOk;
}

Frontend::Frontend() : impl_(std::make_unique<Impl>()) {}
Frontend::~Frontend() = default;

Status Frontend::configure(const FrontendConfig& config, const StereoRig& rig) {
    FACET_TRY(config.validate());
    const CameraIntrinsics& l = rig.left.intrinsics();
    const CameraIntrinsics& r = rig.right.intrinsics();
    FACET_TRY(CameraModel::validate(l));
    FACET_TRY(CameraModel::validate(r));
    if (!(rig.baseline_m() > 1e-3)) {
        return Status::kInvalidArgument;
    }
    Impl& impl = *impl_;
    impl.configured = false;
    impl.config = config;
    impl.rig = rig;
    for (Impl::Sight& sight : impl.sights) {
        FACET_TRY(sight.image.configure(l.width, l.height, config.pyramid_levels));
    }
    FACET_TRY(impl.right.configure(r.width, r.height, config.pyramid_levels));
    impl.engine = config.uses_opencv() ? make_opencv_engine() : make_patch_engine();
    FACET_TRY(impl.engine->configure(config, rig));
    impl.outlier_test.configure(config, rig);
    impl.policy.configure(config);
    impl.dormant.configure(rig);
    impl.dots.configure(std::max(l.width, r.width), std::max(l.height, r.height));
    impl.takes_out_dots = false;
    impl.dots_share = 0.0;
    impl.mask.configure(l.width, l.height);
    impl.right_mask.configure(r.width, r.height);
    impl.has_corrections = false;
    impl.reset();
    impl.configured = true;
    return Status::kOk;
}

void Frontend::reset() { impl_->reset(); }

bool Frontend::ids_run_out() const {
    // A keyframe begins fewer than these.
    constexpr std::uint32_t kReserve = 16 * (kMaxFeatures + kMaxSurfacePoints);
    return impl_->next_landmark > LandmarkId::kInvalid - kReserve;
}

void Frontend::restart_ids(std::uint32_t first) {
    impl_->reset();
    impl_->next_landmark = first;
}

void Frontend::swap(Frontend& other) {
    impl_.swap(other.impl_);
    std::swap(impl_->next_landmark, other.impl_->next_landmark);
}

Status Frontend::process(const StereoFrame& frame, const FrameHints& hints, FrontendOutput& output) {
    return impl_->process(frame, hints, output);
}

Status Frontend::set_masks(const ImageView& left, const ImageView& right) {
    FACET_TRY(impl_->mask.draw(left));
    return impl_->right_mask.draw(right);
}

void Frontend::take_out_dots() {
    impl_->takes_out_dots = true;
    impl_->mask.forget();
    impl_->reset();
}

void Frontend::match_surface(FrontendOutput& output) { impl_->match_surface(output); }

void Frontend::correct_cameras(const CameraCorrections& corrections) {
    impl_->next_corrections = corrections;
    impl_->has_corrections = true;
}

void Frontend::drop_tracks(std::span<const LandmarkId> landmarks) {
    TrackList& tracks = impl_->tracks;
    for (const LandmarkId id : landmarks) {
        const auto at = std::find_if(tracks.begin(), tracks.end(), [id](const Track& t) { return t.id == id; });
        if (at != tracks.end()) {
            impl_->suspect_outlier(*at);
            impl_->remove(static_cast<std::size_t>(at - tracks.begin()));
        }
    }
}

}  // namespace facet
