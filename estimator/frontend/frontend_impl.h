// SPDX-License-Identifier: BSD-2-Clause
// The implementation of Frontend: its parts, the tracks, and the steps of one frame.
#pragma once

#include <algorithm>
#include <array>
#include <boost/container/static_vector.hpp>
#include <cstdint>
#include <memory>

#include "estimator/frontend/dormant_tracks.h"
#include "estimator/frontend/feature_engine.h"
#include "estimator/frontend/frontend.h"
#include "estimator/frontend/image_pyramid.h"
#include "estimator/frontend/keyframe_policy.h"
#include "estimator/frontend/outlier_test.h"
#include "estimator/frontend/track.h"

namespace facet {

/// frontend.cpp contains the order of the steps, frontend_tracking.cpp the steps of every frame, frontend_keyframe.cpp
/// those of keyframes. Heap: in configure() only. Thread-bound.
struct Frontend::Impl {
    FrontendConfig config;
    StereoRig rig;
    bool configured = false;
    ImagePyramid left;
    ImagePyramid previous_left;
    ImagePyramid right;
    std::unique_ptr<FeatureEngine> engine;  ///< by FrontendConfig::backend
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
    boost::container::static_vector<Eigen::Matrix2d, kMaxFeatures> lens_slopes;  ///< d_uv_d_xy of each track
    boost::container::static_vector<StereoQuery, kMaxFeatures + kMaxSurfacePoints> queries;
    std::array<StereoMatch, kMaxFeatures + kMaxSurfacePoints> matches;  ///< of the queries
    std::array<std::uint8_t, kMaxFeatures + kMaxSurfacePoints> found;   ///< of queries, or of tracks that are followed
    std::span<const LandmarkPrediction> predictions;                    ///< for this frame, if has_predictions
    bool has_predictions = false;
    CornerList corners;                  ///< found at this keyframe, but not started as tracks
    bool corners_wait = false;           ///< for match_surface()
    double usual_inverse_depth = 0.0;    ///< of the keyframe's tracks, for it
    CameraCorrections next_corrections;  ///< from the next frame on, if has_corrections
    bool has_corrections = false;

    void reset();
    Status process(const StereoFrame& frame, const FrameHints& hints, FrontendOutput& output);
    ImageState judge_image(const Eigen::Quaterniond& q_Bp_B) const;
    /// The hints' landmarks, asked for once a frame.
    std::span<const LandmarkPrediction> predict(const FrameHints& hints);
    void recall(const FrameHints& hints, FrontendOutput& output);
    void follow_and_choose(const StereoFrame& frame, const FrameHints& hints, FrontendOutput& output);
    Eigen::Vector3d camera_velocity();
    double median();  ///< of `values`, which it reorders; 0 if that is empty
    double median_inverse_depth();
    void follow_tracks(const Eigen::Quaterniond& q_Bp_B, double dt_s, FrontendOutput& output);
    void reject_mono_outliers(FrontendOutput& output);
    void measure_disparity(FrontendOutput& output);
    void make_keyframe(const FrameHints& hints, bool has_right, FrontendOutput& output);
    /// Number of tracks that a keyframe is filled up to.
    int wanted_features(const FrameHints& hints) const;
    void begin_tracks(const FrameHints& hints, bool has_right, FrontendOutput& output);
    void match_stereo(const FrameHints& hints);
    void match_queries(double usual_inverse_depth);
    void match_surface(FrontendOutput& output);
    void reject_stereo_outliers();
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

}  // namespace facet
