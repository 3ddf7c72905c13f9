// SPDX-License-Identifier: BSD-2-Clause
#include <algorithm>
#include <cmath>
#include <iterator>

#include "estimator/frontend/frontend_impl.h"

namespace facet {

std::span<const LandmarkPrediction> Frontend::Impl::predict(const FrameHints& hints) {
    if (!has_predictions) {
        predictions = hints.landmarks != nullptr ? hints.landmarks->predict() : std::span<const LandmarkPrediction>();
        has_predictions = true;
    }
    return predictions;
}

void Frontend::Impl::recall(const FrameHints& hints, FrontendOutput& output) {
    if (predict(hints).empty()) {
        return;
    }
    const std::size_t before = tracks.size();
    dormant.forget_unknown(predictions, *engine);
    dormant.recall(left, predictions, sights[0].q_B0_B, wanted_features(hints), *engine, tracks);
    output.recalled += static_cast<int>(tracks.size() - before);
}

int Frontend::Impl::wanted_features(const FrameHints& hints) const {
    return static_cast<int>(std::lround(hints.effort * config.max_features));
}

void Frontend::Impl::begin_tracks(const FrameHints& hints, bool has_right, FrontendOutput& output) {
    positions.clear();
    for (const Track& track : tracks) {
        positions.push_back(track.pose.uv);
    }
    corners.clear();
    const int wanted = std::max(0, wanted_features(hints) - static_cast<int>(tracks.size()));
    const int more = has_right && hints.effort >= 1.0 ? config.surface_points : 0;
    engine->detect(left, mask, output.stamp, {positions.data(), positions.size()}, wanted + more, corners);
    const auto rest = corners.begin() + std::min<std::ptrdiff_t>(wanted, std::ssize(corners));
    for (auto uv = corners.begin(); uv != rest; ++uv) {
        Track track;
        Status started = engine->start(left, *uv, track);
        if (started == Status::kFull && dormant.forget_oldest(*engine)) {
            started = engine->start(left, *uv, track);
        }
        if (ok(started)) {
            track.id.value = next_landmark++;
            track.turn = next_turn++;
            watch(track);
            tracks.push_back(track);
            ++output.detected;
        }
    }
    corners.erase(corners.begin(), rest);
}

void Frontend::Impl::match_queries(double usual) {
    engine->match(left, right, {queries.data(), queries.size()}, usual, {matches.data(), queries.size()},
                  {found.data(), queries.size()});
}

void Frontend::Impl::match_stereo(const FrameHints& hints) {
    stereo_pairs.clear();
    pair_tracks.clear();
    queries.clear();
    for (const Track& track : tracks) {
        // The camera has moved since the last keyframe: the smoother knows better than the old depth. What was never
        // matched is searched, so that the match is independent of what the smoother believes.
        const bool had_depth = track.has_depth;
        const LandmarkPrediction* predicted = had_depth ? find_prediction(predict(hints), track.id) : nullptr;
        const bool is_predicted = predicted != nullptr && predicted->in_view;
        const double usual = had_depth ? track.inverse_depth : -1.0;
        queries.push_back({track.pose.uv, is_predicted ? predicted->inverse_depth : usual});
    }
    match_queries(median_inverse_depth());
    for (std::size_t i = 0; i < tracks.size(); ++i) {
        Track& track = tracks[i];
        const StereoMatch& match = matches[i];
        const bool had_depth = track.has_depth;
        const Eigen::Vector3d before =
            had_depth ? (track.keyframe_xy.homogeneous() / track.inverse_depth).eval() : Eigen::Vector3d::Zero();
        track.has_right = found[i] != 0 && !right_mask.is_drawn(match.right_uv);
        track.has_depth = track.has_right;
        if (!track.has_right) {
            continue;
        }
        track.right_uv = match.right_uv;
        track.right_xy = match.right_xy;
        track.inverse_depth = match.inverse_depth;
        if (had_depth) {
            stereo_pairs.push_back({before, match.p_C0});
            pair_tracks.push_back(static_cast<std::uint16_t>(i));
        }
    }
    reject_stereo_outliers();
}

/// Matches the corners at which no track begins: their position is known from this frame alone.
void Frontend::Impl::match_surface(FrontendOutput& output) {
    if (!corners_wait) {
        return;
    }
    corners_wait = false;
    queries.clear();
    for (const Eigen::Vector2d& uv : corners) {
        queries.push_back({uv, -1.0});
    }
    match_queries(usual_inverse_depth);
    for (std::size_t i = 0; i < queries.size() && output.surface.size() < output.surface.capacity(); ++i) {
        FeatureObservation o;
        if (found[i] == 0 || right_mask.is_drawn(matches[i].right_uv) ||
            !ok(rig.left.unproject(queries[i].left_uv, o.left_xy))) {
            continue;
        }
        o.landmark.value = next_landmark++;
        o.left_px = queries[i].left_uv.cast<float>();
        o.right_xy = matches[i].right_xy;
        o.right_px = matches[i].right_uv.cast<float>();
        o.has_right = true;
        output.surface.push_back(o);
    }
}

void Frontend::Impl::reject_stereo_outliers() {
    inlier.resize(stereo_pairs.size());
    const Eigen::Matrix3d R = q_C_Ck().toRotationMatrix();
    if (!ok(outlier_test.stereo({stereo_pairs.data(), stereo_pairs.size()}, R, {inlier.data(), inlier.size()}))) {
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
    begin_tracks(hints, has_right, output);
    if (has_right) {
        match_stereo(hints);
        corners_wait = true;
        usual_inverse_depth = median_inverse_depth();
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
        if (track.unseen != 0) {
            continue;
        }
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

}  // namespace facet
