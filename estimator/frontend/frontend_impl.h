// SPDX-License-Identifier: BSD-2-Clause
// The implementation of Frontend: its parts, the tracks, and the steps of one frame.
#pragma once

#include <algorithm>
#include <array>
#include <boost/container/static_vector.hpp>
#include <cstdint>
#include <memory>
#include <optional>

#include "estimator/frontend/dormant_tracks.h"
#include "estimator/frontend/dot_filter.h"
#include "estimator/frontend/feature_engine.h"
#include "estimator/frontend/frontend.h"
#include "estimator/frontend/image_pyramid.h"
#include "estimator/frontend/keyframe_policy.h"
#include "estimator/frontend/outlier_test.h"
#include "estimator/frontend/pixel_mask.h"
#include "estimator/frontend/track.h"
#include "estimator/frontend/tracker.h"

namespace facet {

/// frontend.cpp contains the order of the steps, frontend_tracking.cpp the steps of every frame, frontend_fixed.cpp
/// what is left out of them, frontend_turn.cpp a measurement beside them, frontend_keyframe.cpp those of keyframes.
/// Heap: in configure() only. Thread-bound.
struct Frontend::Impl {
    FrontendConfig config;
    StereoRig rig;
    bool configured = false;
    /// A left image, and where the body was.
    struct Sight {
        ImagePyramid image;
        Eigen::Quaterniond q_B0_B = Eigen::Quaterniond::Identity();  ///< body then to body at the first frame
        Eigen::Quaterniond q_B0_B_as_read =
            Eigen::Quaterniond::Identity();  ///< the same by the gyroscope, suspected or not
        Timestamp stamp;
    };
    std::array<Sight, kMaxTurns + 1> sights;  ///< the present one, then those before it
    ImagePyramid& left = sights[0].image;
    ImagePyramid right;
    std::unique_ptr<FeatureEngine> engine;  ///< by FrontendConfig::backend
    OutlierTest outlier_test;
    KeyframePolicy policy;
    PixelMask mask;
    PixelMask right_mask;  ///< drawn only
    /// Where tracks were on dots, if most were.
    struct Dots {
        Timestamp stamp;
        Eigen::Quaterniond q_B0_B = Eigen::Quaterniond::Identity();  ///< Sight::q_B0_B_as_read
        boost::container::static_vector<Eigen::Vector2d, kMaxFeatures> places;
    };
    Dots dots_then;
    DotFilter dots;
    bool takes_out_dots = false;
    double dots_share = 0.0;  ///< of the newest image that has been filtered

    TrackList tracks;
    DormantTracks dormant;
    std::uint32_t next_landmark = 0;
    std::uint32_t next_turn = 0;  ///< of the next track
    bool has_previous = false;
    bool was_still = false;
    Timestamp keyframe_stamp;
    Eigen::Quaterniond q_Bk_B = Eigen::Quaterniond::Identity();  ///< body now to body at the last keyframe
    std::uint32_t frame_number = 0;                              ///< number of the present one, for turns
    int keyframe_tracks = 0;                                     ///< tracks the last keyframe had

    boost::container::static_vector<MonoPair, kMaxFeatures> mono_pairs;
    boost::container::static_vector<StereoPair, kMaxFeatures> stereo_pairs;
    boost::container::static_vector<std::uint16_t, kMaxFeatures> pair_tracks;   ///< index of each pair's track
    TrackList group;                                                            ///< that is followed from one image
    boost::container::static_vector<std::uint16_t, kMaxFeatures> group_tracks;  ///< index of each one's track
    boost::container::static_vector<std::uint8_t, kMaxFeatures> inlier;
    boost::container::static_vector<double, kMaxFeatures> values;
    boost::container::static_vector<Eigen::Vector2d, kMaxFeatures> positions;
    boost::container::static_vector<Eigen::Matrix2d, kMaxFeatures> lens_slopes;  ///< d_uv_d_xy of each track
    boost::container::static_vector<StereoQuery, kMaxFeatures + kMaxSurfacePoints> queries;
    std::array<StereoMatch, kMaxFeatures + kMaxSurfacePoints> matches;  ///< of the queries
    std::array<std::uint8_t, kMaxFeatures + kMaxSurfacePoints> found;   ///< of queries, or of tracks
    std::array<std::uint8_t, kMaxFeatures> group_found;                 ///< of the group
    std::span<const LandmarkPrediction> predictions;                    ///< for this frame, if has_predictions
    bool has_predictions = false;
    CornerList corners;                  ///< found at this keyframe, but not started as tracks
    bool corners_wait = false;           ///< for match_surface()
    double usual_inverse_depth = 0.0;    ///< of the keyframe's tracks, for it
    CameraCorrections next_corrections;  ///< from the next frame on, if has_corrections
    bool has_corrections = false;

    void reset();
    Status process(const StereoFrame& frame, const FrameHints& hints, FrontendOutput& output);
    /// Makes room for the present image, the others become one frame older.
    void begin_sight(const StereoFrame& frame, const FrameHints& hints);
    ImageState judge_image(const Eigen::Quaterniond& q_Bp_B) const;
    /// The hints' landmarks, asked for once a frame.
    std::span<const LandmarkPrediction> predict(const FrameHints& hints);
    void recall(const FrameHints& hints, FrontendOutput& output);
    void follow_and_choose(const StereoFrame& frame, const FrameHints& hints, FrontendOutput& output);
    Eigen::Vector3d camera_velocity();
    double median();  ///< of `values`, which it reorders; 0 if that is empty
    double median_inverse_depth();
    /// Prepares the tracks for a new image, which sees none of them yet.
    void age_tracks();
    /// How many frames there are to a track's turn.
    std::uint32_t turns() const;
    /// Motion of the left camera since the frame that was so many frames ago.
    FrameMotion motion_since(int frames) const;
    /// Follows those tracks of which is_due(track), and drops those that are lost.
    /// @return whether they moved as predicted, all but a few
    template <class Predicate>
    bool follow_tracks(Predicate is_due, FrontendOutput& output);
    /// Those not `found`. @return how many
    std::size_t drop_lost(FrontendOutput& output);
    /// Those whose turn it is; all of them in a frame that is not like those before it.
    void follow_in_turns(const FrameHints& hints, FrontendOutput& output);
    /// Those that have not been followed to this image yet.
    void follow_rest(FrontendOutput& output);
    void reject_mono_outliers(FrontendOutput& output);
    /// Remembers where a track is now, to be judged once the vehicle has turned.
    void watch(Track& track) const;
    /// How far a watched track has gone, over how far the vehicle's turn alone would have moved it; nothing if that is
    /// less than `least_px`.
    std::optional<double> share_of_turn(const Track& track, double least_px) const;
    void judge_fixed(Track& track) const;
    /// Notes where outliers stay while the vehicle turns.
    void suspect_outlier(const Track& track);
    /// Drops tracks on what the user has masked, and, if images contradict the gyroscope while others agree with it,
    /// those that stay where they are while the vehicle turns; there none begin for a while.
    void leave_out_fixed(const FrameHints& hints, FrontendOutput& output);
    /// Whether most tracks are on dots that stay where they are while the vehicle turns and images contradict it.
    bool shows_dots(const ImageView& image, const FrameHints& hints);
    /// The image as it is tracked in and matched.
    ImageView without_dots(const ImageView& image);
    /// By how much the images have turned since the frame in which most tracks were seen last.
    void measure_turn(FrontendOutput& output);
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
    /// Number of tracks that the present image has been searched for and sees.
    std::size_t observed() const {
        return static_cast<std::size_t>(
            std::count_if(tracks.begin(), tracks.end(), [](const Track& t) { return t.unseen == 0; }));
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
