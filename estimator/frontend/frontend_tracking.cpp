// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/frontend/frontend_impl.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace facet {
namespace {

// A frame is not like those before it if one track of so many is lost in it, or if half of the tracks come so far off
// their predictions.
constexpr std::size_t kFewLost = 4;
constexpr double kSurprise_px = 6.0;

}  // namespace

Eigen::Vector3d Frontend::Impl::camera_velocity() {
    // Rotation apart, a point of inverse depth rho moves by xy' = rho (v.z() xy - v.head<2>()), v the velocity of the
    // camera in its own frame: linear in v. Robust least squares over the tracks that have both, in pixels of the
    // image; Cauchy weights.
    constexpr double kScale = 20.0;  // px/s: 1 px a frame at 20 Hz
    constexpr double kPrior = 0.2;   // px^2: keeps v where nothing is seen
    lens_slopes.clear();
    for (const Track& track : tracks) {
        lens_slopes.push_back(rig.left.d_uv_d_xy(track.xy));
    }
    Eigen::Vector3d v = Eigen::Vector3d::Zero();
    for (int step = 0; step < 4; ++step) {
        Eigen::Matrix3d h = kPrior * Eigen::Matrix3d::Identity();
        Eigen::Vector3d g = Eigen::Vector3d::Zero();
        for (std::size_t i = 0; i < tracks.size(); ++i) {
            const Track& track = tracks[i];
            if (track.has_depth && track.has_velocity) {
                Eigen::Matrix<double, 2, 3> d_xy_d_v;
                d_xy_d_v << -1.0, 0.0, track.xy.x(), 0.0, -1.0, track.xy.y();
                const Eigen::Matrix<double, 2, 3> j = track.inverse_depth * lens_slopes[i] * d_xy_d_v;
                const Eigen::Vector2d seen = lens_slopes[i] * track.velocity;
                const double w = step == 0 ? 1.0 : 1.0 / (1.0 + (seen - j * v).squaredNorm() / (kScale * kScale));
                h += w * j.transpose() * j;
                g += w * j.transpose() * seen;
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

void Frontend::Impl::age_tracks() {
    // New tracks have no velocity of their own: it is computed from the camera's velocity and their depth.
    const double usual = median_inverse_depth();
    const Eigen::Vector3d v = camera_velocity();
    for (Track& track : tracks) {
        ++track.unseen;
        track.has_right = false;
        if (!track.has_velocity) {
            const double rho = track.has_depth ? track.inverse_depth : usual;
            track.velocity = rho * (v.z() * track.xy - v.head<2>());
        }
    }
}

FrameMotion Frontend::Impl::motion_since(int frames) const {
    const Sight& then = sights[static_cast<std::size_t>(frames)];
    const Eigen::Quaterniond q_B_Bt = sights[0].q_B0_B.conjugate() * then.q_B0_B;
    return {(rig.T_B_C0.q.conjugate() * q_B_Bt * rig.T_B_C0.q).normalized(), (sights[0].stamp - then.stamp).seconds()};
}

std::uint32_t Frontend::Impl::turns() const {
    constexpr int kEnough = 100;  // tracks in a frame: its pose hardly gains from more
    return static_cast<std::uint32_t>(std::clamp(static_cast<int>(tracks.size()) / kEnough, 1, engine->reach()));
}

template <class Predicate>
bool Frontend::Impl::follow_tracks(Predicate is_due, FrontendOutput& output) {
    found.fill(1);
    values.clear();  // how far tracks came off their predictions, squared (normalised)
    std::size_t due = 0;
    for (int frames = 1; frames <= kMaxTurns; ++frames) {
        group.clear();
        group_tracks.clear();
        for (std::size_t i = 0; i < tracks.size(); ++i) {
            if (tracks[i].unseen == frames && is_due(tracks[i])) {
                group.push_back(tracks[i]);
                group_tracks.push_back(static_cast<std::uint16_t>(i));
            }
        }
        if (group.empty()) {
            continue;
        }
        due += group.size();
        const FrameMotion motion = motion_since(frames);
        engine->follow(sights[static_cast<std::size_t>(frames)].image, left, motion, {group.data(), group.size()},
                       {group_found.data(), group.size()});
        for (std::size_t k = 0; k < group.size(); ++k) {
            Track& track = tracks[group_tracks[k]];
            found[group_tracks[k]] = group_found[k];
            if (group_found[k] != 0) {
                values.push_back(motion.dt_s * motion.dt_s * (group[k].velocity - track.velocity).squaredNorm());
                track = group[k];
                track.age_frames += static_cast<std::uint32_t>(frames - 1);  // the engine counts one
                track.unseen = 0;
                track.span = frames;
            }
        }
    }
    const std::size_t lost = drop_lost(output);
    return kFewLost * lost <= due && rig.left.focal_px() * std::sqrt(median()) < kSurprise_px;
}

std::size_t Frontend::Impl::drop_lost(FrontendOutput& output) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < tracks.size(); ++i) {
        if (found[i] != 0) {
            tracks[kept++] = tracks[i];
        } else {
            dormant.add(tracks[i], sights[static_cast<std::size_t>(tracks[i].unseen)].q_B0_B, *engine);
        }
    }
    const std::size_t lost = tracks.size() - kept;
    output.lost += static_cast<int>(lost);
    tracks.resize(kept);
    return lost;
}

void Frontend::Impl::follow_in_turns(const FrameHints& hints, FrontendOutput& output) {
    const std::uint32_t every = hints.is_uncertain ? 1 : turns();
    const bool is_as_predicted = follow_tracks(
        [this, every](const Track& track) {
            const bool is_its_turn = (track.turn + frame_number) % every == 0;
            return is_its_turn || track.unseen >= static_cast<int>(every) || !track.has_velocity;
        },
        output);
    if (!is_as_predicted) {
        follow_rest(output);
    }
}

void Frontend::Impl::follow_rest(FrontendOutput& output) {
    static_cast<void>(follow_tracks([](const Track&) { return true; }, output));
}

void Frontend::Impl::reject_mono_outliers(FrontendOutput& output) {
    mono_pairs.clear();
    pair_tracks.clear();
    const Eigen::Matrix3d R = q_C_Ck().toRotationMatrix();
    for (std::size_t i = 0; i < tracks.size(); ++i) {
        if (tracks[i].in_keyframe && tracks[i].unseen == 0) {
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
            suspect_outlier(tracks[pair_tracks[k]]);
            remove(pair_tracks[k]);
            ++output.outliers;
            ++output.lost;
        }
    }
}

void Frontend::Impl::measure_disparity(FrontendOutput& output) {
    // Without a good gyroscope bias (before initialization) the compensated disparity of a vehicle at rest is not
    // small, but the plain one is: one of the two suffices for standing still.
    const auto disparity_after = [this](const Eigen::Matrix3d& R) {
        values.clear();
        for (const Track& track : tracks) {
            Eigen::Vector2d uv;
            if (track.in_keyframe && track.unseen == 0 &&
                ok(rig.left.project(R * track.keyframe_xy.homogeneous(), uv))) {
                values.push_back((uv - track.pose.uv).norm());
            }
        }
        return median();
    };
    output.median_disparity_px = disparity_after(q_C_Ck().toRotationMatrix());
    const bool any = !values.empty();
    output.rest_disparity_px = std::min(output.median_disparity_px, disparity_after(Eigen::Matrix3d::Identity()));
    const bool small = any && output.rest_disparity_px < FrontendConfig::kStillDisparity_px;
    // Shortly after a keyframe the disparity is small at any speed: the keyframe's verdict is kept.
    const bool long_enough = (output.stamp - keyframe_stamp).seconds() >= FrontendConfig::kKeyframeMinInterval_s - 1e-3;
    output.is_still = small && (long_enough || was_still);
    was_still = output.is_still;
}

}  // namespace facet
