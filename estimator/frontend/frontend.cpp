// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/frontend.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <utility>

#include "estimator/frontend/detector.h"
#include "estimator/frontend/dormant_tracks.h"
#include "estimator/frontend/image_check.h"
#include "estimator/frontend/image_pyramid.h"
#include "estimator/frontend/keyframe_policy.h"
#include "estimator/frontend/outlier_test.h"
#include "estimator/frontend/stereo_matcher.h"
#include "estimator/frontend/track.h"
#include "estimator/frontend/tracker.h"

namespace facet {

struct Frontend::Impl {
    FrontendConfig config;
    StereoRig rig;
    bool configured = false;
    ImagePyramid left;
    ImagePyramid previous_left;
    ImagePyramid right;
    Detector detector;
    Tracker tracker;
    StereoMatcher stereo_matcher;
    OutlierTest outlier_test;
    KeyframePolicy policy;

    TrackList tracks;
    DormantTracks dormant;
    std::uint32_t next_landmark = 0;
    bool has_previous = false;
    bool was_still = false;
    Timestamp previous_stamp;
    Timestamp keyframe_stamp;
    Eigen::Quaterniond q_Bk_B = Eigen::Quaterniond::Identity();   ///< body now to body at the last keyframe
    Eigen::Quaterniond q_B0_B = Eigen::Quaterniond::Identity();   ///< body now to body at the first frame
    Eigen::Quaterniond q_B0_Bp = Eigen::Quaterniond::Identity();  ///< likewise, at the previous frame
    int keyframe_tracks = 0;                                      ///< tracks the last keyframe had

    boost::container::static_vector<MonoPair, kMaxFeatures> mono_pairs;
    boost::container::static_vector<StereoPair, kMaxFeatures> stereo_pairs;
    boost::container::static_vector<std::uint16_t, kMaxFeatures> pair_tracks;  ///< index of each pair's track
    boost::container::static_vector<std::uint8_t, kMaxFeatures> inlier;
    boost::container::static_vector<double, kMaxFeatures> values;
    boost::container::static_vector<Eigen::Vector2d, kMaxFeatures> positions;
    CornerList corners;

    void reset();
    Status process(const StereoFrame& frame, const FrameHints& hints, FrontendOutput& output);
    ImageState judge_image(const Eigen::Quaterniond& q_Bp_B) const;
    void recall(const FrameHints& hints, FrontendOutput& output);
    void follow_and_choose(const StereoFrame& frame, const FrameHints& hints, FrontendOutput& output);
    Eigen::Vector3d camera_velocity() const;
    double median();  ///< of `values`, which it reorders; 0 if there are none
    double median_inverse_depth();
    void follow_tracks(const Eigen::Quaterniond& q_Bp_B, double dt_s, FrontendOutput& output);
    void reject_mono_outliers(FrontendOutput& output);
    void measure_disparity(FrontendOutput& output);
    void make_keyframe(const FrameHints& hints, bool has_right, FrontendOutput& output);
    void match_stereo();
    void fill_observations(FrontendOutput& output) const;
    int live() const {
        return static_cast<int>(
            std::count_if(tracks.begin(), tracks.end(), [](const Track& t) { return t.in_keyframe; }));
    }
    void remove(std::size_t index);
    bool image_ok(const ImageView& view, const CameraModel& camera) const {
        return !view.empty() && view.width == camera.intrinsics().width && view.height == camera.intrinsics().height &&
               view.stride >= view.width;
    }
    /// Turns bearings of the left camera at the last keyframe into bearings now.
    Eigen::Quaterniond q_C_Ck() const { return rig.T_B_C0.q.conjugate() * q_Bk_B.conjugate() * rig.T_B_C0.q; }
};

void Frontend::Impl::reset() {
    tracks.clear();
    dormant.clear();
    tracker.reset();
    policy.reset();
    has_previous = false;
    was_still = false;
    q_Bk_B.setIdentity();
    q_B0_B.setIdentity();
    keyframe_tracks = 0;
}

void Frontend::Impl::remove(std::size_t index) {
    tracker.stop(tracks[index]);
    tracks.erase(tracks.begin() + static_cast<std::ptrdiff_t>(index));
}

Eigen::Vector3d Frontend::Impl::camera_velocity() const {
    // Rotation apart, a point of inverse depth rho moves by xy' = rho (v.z() xy - v.head<2>()), v the velocity of the
    // camera in its own frame: linear in v. Robust least squares over the tracks that have both; Cauchy weights.
    constexpr double kScale = 0.05;  // 1/s: about 1 px a frame at 20 Hz
    Eigen::Vector3d v = Eigen::Vector3d::Zero();
    for (int step = 0; step < 4; ++step) {
        Eigen::Matrix3d h = 1e-6 * Eigen::Matrix3d::Identity();
        Eigen::Vector3d g = Eigen::Vector3d::Zero();
        for (const Track& track : tracks) {
            if (track.has_depth && track.has_velocity) {
                Eigen::Matrix<double, 2, 3> j;
                j << -1.0, 0.0, track.xy.x(), 0.0, -1.0, track.xy.y();
                j *= track.inverse_depth;
                const double w =
                    step == 0 ? 1.0 : 1.0 / (1.0 + (track.velocity - j * v).squaredNorm() / (kScale * kScale));
                h += w * j.transpose() * j;
                g += w * j.transpose() * track.velocity;
            }
        }
        v = h.ldlt().solve(g);
    }
    return v;
}

double Frontend::Impl::median() {
    if (values.empty()) {
        return 0.0;
    }
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

double Frontend::Impl::median_inverse_depth() {
    values.clear();
    for (const Track& track : tracks) {
        if (track.has_depth) {
            values.push_back(track.inverse_depth);
        }
    }
    return median();
}

void Frontend::Impl::follow_tracks(const Eigen::Quaterniond& q_Bp_B, double dt_s, FrontendOutput& output) {
    FrameMotion motion;
    motion.q_C_Cp = (rig.T_B_C0.q.conjugate() * q_Bp_B.conjugate() * rig.T_B_C0.q).normalized();
    motion.dt_s = dt_s;
    // New tracks have no velocity of their own: that of the camera, and their depth, give them one.
    const double usual = median_inverse_depth();
    const Eigen::Vector3d v = camera_velocity();
    std::size_t kept = 0;
    for (std::size_t i = 0; i < tracks.size(); ++i) {
        Track track = tracks[i];
        track.has_right = false;
        if (!track.has_velocity) {
            const double rho = track.has_depth ? track.inverse_depth : usual;
            track.velocity = rho * (v.z() * track.xy - v.head<2>());
        }
        if (ok(tracker.follow(previous_left, left, motion, track))) {
            tracks[kept++] = track;
        } else {
            dormant.add(track, q_B0_Bp, tracker);
            ++output.lost;
        }
    }
    tracks.resize(kept);
}

void Frontend::Impl::reject_mono_outliers(FrontendOutput& output) {
    mono_pairs.clear();
    pair_tracks.clear();
    const Eigen::Matrix3d R = q_C_Ck().toRotationMatrix();
    for (std::size_t i = 0; i < tracks.size(); ++i) {
        if (tracks[i].in_keyframe) {
            mono_pairs.push_back({R * tracks[i].keyframe_xy.homogeneous(), tracks[i].xy});
            pair_tracks.push_back(static_cast<std::uint16_t>(i));
        }
    }
    inlier.resize(mono_pairs.size());
    if (!ok(outlier_test.mono({mono_pairs.data(), mono_pairs.size()}, {inlier.data(), inlier.size()}))) {
        return;
    }
    for (std::size_t k = pair_tracks.size(); k-- > 0;) {
        if (inlier[k] == 0) {
            remove(pair_tracks[k]);
            ++output.outliers;
            ++output.lost;
        }
    }
}

void Frontend::Impl::measure_disparity(FrontendOutput& output) {
    // Without a good gyroscope bias (before initialization) the compensated disparity of a vehicle at rest is not
    // small, but the plain one is: standing still is either.
    const auto disparity_after = [this](const Eigen::Matrix3d& R) {
        values.clear();
        for (const Track& track : tracks) {
            const Eigen::Vector3d rotated = R * track.keyframe_xy.homogeneous();
            if (track.in_keyframe && rotated.z() > 0.1) {
                values.push_back((rotated.hnormalized() - track.xy).norm() * rig.left.focal_px());
            }
        }
        return median();
    };
    output.median_disparity_px = disparity_after(q_C_Ck().toRotationMatrix());
    const bool any = !values.empty();
    const double plain_px = disparity_after(Eigen::Matrix3d::Identity());
    const bool small = any && std::min(output.median_disparity_px, plain_px) < config.still_disparity_px;
    // Shortly after a keyframe the disparity is small at any speed: the verdict of the keyframe stands.
    const bool long_enough = (output.stamp - keyframe_stamp).seconds() >= config.keyframe_min_interval_s - 1e-3;
    output.is_still = small && (long_enough || was_still);
    was_still = output.is_still;
}

void Frontend::Impl::match_stereo() {
    stereo_pairs.clear();
    pair_tracks.clear();
    const Eigen::Matrix3d R = q_C_Ck().toRotationMatrix();
    for (std::size_t i = 0; i < tracks.size(); ++i) {
        Track& track = tracks[i];
        const bool had_depth = track.has_depth;
        const Eigen::Vector3d before =
            had_depth ? (track.keyframe_xy.homogeneous() / track.inverse_depth).eval() : Eigen::Vector3d::Zero();
        StereoMatch match;
        track.has_right =
            ok(stereo_matcher.match(left, right, track.pose.uv, had_depth ? track.inverse_depth : -1.0, match));
        track.has_depth = track.has_right;
        if (!track.has_right) {
            continue;
        }
        track.right_uv = match.right_uv;
        track.right_xy = match.right_xy;
        track.inverse_depth = match.inverse_depth;
        if (had_depth) {
            stereo_pairs.push_back({R * before, match.p_C0});
            pair_tracks.push_back(static_cast<std::uint16_t>(i));
        }
    }
    inlier.resize(stereo_pairs.size());
    if (!ok(outlier_test.stereo({stereo_pairs.data(), stereo_pairs.size()}, {inlier.data(), inlier.size()}))) {
        return;
    }
    for (std::size_t k = 0; k < pair_tracks.size(); ++k) {
        if (inlier[k] == 0) {
            tracks[pair_tracks[k]].has_right = false;
            tracks[pair_tracks[k]].has_depth = false;
        }
    }
}

void Frontend::Impl::make_keyframe(const FrameHints& hints, bool has_right, FrontendOutput& output) {
    recall(hints, output);
    positions.clear();
    for (const Track& track : tracks) {
        positions.push_back(track.pose.uv);
    }
    corners.clear();
    detector.detect(left.level(0), {positions.data(), positions.size()},
                    config.max_features - static_cast<int>(tracks.size()), corners);
    for (const Eigen::Vector2d& uv : corners) {
        Track track;
        Status started = tracker.start(left, uv, track);
        if (started == Status::kFull && dormant.forget_oldest(tracker)) {
            started = tracker.start(left, uv, track);
        }
        if (ok(started)) {
            track.id.value = next_landmark++;
            tracks.push_back(track);
            ++output.detected;
        }
    }
    if (has_right) {
        match_stereo();
    } else {
        for (Track& track : tracks) {
            track.has_depth = false;
        }
    }
    for (Track& track : tracks) {
        track.in_keyframe = true;
        track.keyframe_xy = track.xy;
    }
    dormant.leave_keyframe();
    keyframe_tracks = static_cast<int>(tracks.size());
    q_Bk_B.setIdentity();
    keyframe_stamp = output.stamp;
}

void Frontend::Impl::fill_observations(FrontendOutput& output) const {
    for (const Track& track : tracks) {
        FeatureObservation o;
        o.landmark = track.id;
        o.left_xy = track.xy;
        o.left_px = track.pose.uv.cast<float>();
        o.age_frames = track.age_frames;
        o.has_right = track.has_right;
        if (track.has_right) {
            o.right_xy = track.right_xy;
            o.right_px = track.right_uv.cast<float>();
            ++output.stereo;
        }
        output.observations.push_back(o);
    }
}

ImageState Frontend::Impl::judge_image(const Eigen::Quaterniond& q_Bp_B) const {
    constexpr double kTurned = 1e-3;  // rad: more than the gyroscope may err from frame to frame
    if (has_previous && q_Bp_B.vec().norm() > 0.5 * kTurned && is_same_image(left.level(0), previous_left.level(0))) {
        return ImageState::kFrozen;
    }
    return check_image(left.level(left.levels() - 1));
}

void Frontend::Impl::recall(const FrameHints& hints, FrontendOutput& output) {
    if (hints.landmarks.empty() || config.recall_radius_px <= 0.0) {
        return;
    }
    const std::size_t before = tracks.size();
    dormant.forget_unknown(hints.landmarks, tracker);
    dormant.recall(left, hints.landmarks, q_B0_B, config.max_features, tracker, tracks);
    output.recalled += static_cast<int>(tracks.size() - before);
}

void Frontend::Impl::follow_and_choose(const StereoFrame& frame, const FrameHints& hints, FrontendOutput& output) {
    const bool has_right = !frame.right.empty();
    if (has_previous) {
        follow_tracks(hints.q_Bp_B, (frame.stamp - previous_stamp).seconds(), output);
        if (2 * live() < keyframe_tracks) {
            recall(hints, output);  // most tracks lost at once: after darkness, or behind something large
        }
        reject_mono_outliers(output);
    }
    output.tracked = static_cast<int>(tracks.size());
    measure_disparity(output);
    output.is_keyframe = policy.decide(
        {frame.stamp, live(), keyframe_tracks, output.median_disparity_px, has_right, hints.wants_keyframe});
    if (output.is_keyframe) {
        if (has_right) {
            right.build(frame.right);
        }
        make_keyframe(hints, has_right, output);
    }
    fill_observations(output);
}

Status Frontend::Impl::process(const StereoFrame& frame, const FrameHints& hints, FrontendOutput& result) {
    const bool has_right = !frame.right.empty();
    if (!configured || !image_ok(frame.left, rig.left) || (has_right && !image_ok(frame.right, rig.right)) ||
        !(std::abs(hints.q_Bp_B.norm() - 1.0) < 1e-3)) {
        return Status::kInvalidArgument;
    }
    if (has_previous && frame.stamp <= previous_stamp) {
        return Status::kOutOfOrder;
    }
    FrontendOutput output;
    output.stamp = frame.stamp;
    std::swap(left, previous_left);
    left.build(frame.left);
    q_Bk_B = (q_Bk_B * hints.q_Bp_B).normalized();
    q_B0_Bp = q_B0_B;
    q_B0_B = (q_B0_B * hints.q_Bp_B).normalized();
    output.image = judge_image(hints.q_Bp_B);
    if (output.image == ImageState::kUsable) {
        follow_and_choose(frame, hints, output);
    } else {
        for (const Track& track : tracks) {
            dormant.add(track, q_B0_Bp, tracker);
        }
        output.lost = static_cast<int>(tracks.size());
        tracks.clear();
    }
    has_previous = true;
    previous_stamp = frame.stamp;
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
    try {
        cv::setNumThreads(1);
    } catch (const cv::Exception&) {
        return Status::kCorrupt;
    }
    FACET_TRY(impl.left.configure(l.width, l.height, config.pyramid_levels));
    FACET_TRY(impl.previous_left.configure(l.width, l.height, config.pyramid_levels));
    FACET_TRY(impl.right.configure(r.width, r.height, config.pyramid_levels));
    FACET_TRY(impl.tracker.configure(config, rig.left));
    FACET_TRY(impl.stereo_matcher.configure(config, rig));
    impl.detector.configure(config, l.width, l.height, impl.tracker.border_px());
    impl.outlier_test.configure(config, rig.left.focal_px(), rig.baseline_m());
    impl.policy.configure(config);
    impl.dormant.configure(config, rig);
    impl.reset();
    impl.configured = true;
    return Status::kOk;
}

void Frontend::reset() { impl_->reset(); }

Status Frontend::process(const StereoFrame& frame, const FrameHints& hints, FrontendOutput& output) {
    try {
        return impl_->process(frame, hints, output);
    } catch (const cv::Exception&) {
        impl_->reset();
        return Status::kCorrupt;
    }
}

void Frontend::drop_tracks(std::span<const LandmarkId> landmarks) {
    TrackList& tracks = impl_->tracks;
    for (const LandmarkId id : landmarks) {
        const auto at = std::find_if(tracks.begin(), tracks.end(), [id](const Track& t) { return t.id == id; });
        if (at != tracks.end()) {
            impl_->remove(static_cast<std::size_t>(at - tracks.begin()));
        }
    }
}

}  // namespace facet
