// SPDX-License-Identifier: BSD-2-Clause
// Lost tracks, kept until the smoother drops their landmark, and found again where it is predicted.
#pragma once

#include <Eigen/Geometry>
#include <boost/container/static_vector.hpp>
#include <span>

#include "estimator/frontend/feature_engine.h"
#include "estimator/frontend/frontend_config.h"
#include "estimator/frontend/frontend_types.h"
#include "estimator/frontend/image_pyramid.h"
#include "estimator/frontend/track.h"
#include "estimator/geometry/stereo_rig.h"
#include "estimator/values/observation.h"

namespace facet {

/// The prediction of a landmark among predictions sorted by id; nullptr if it has none. Reentrant.
const LandmarkPrediction* find_prediction(std::span<const LandmarkPrediction> predictions, LandmarkId id);

using TrackList = boost::container::static_vector<Track, kMaxFeatures>;

/// A track ends when its point leaves the image or is hidden, or when the image goes dark. Its template is kept here.
/// If the smoother later predicts the landmark inside the image, the template is aligned there, rotated and scaled
/// according to the camera's motion since; a track that is found continues as the same landmark. So a second of
/// darkness costs no more than the inertial drift meanwhile, and a look back to a former place closes the loop within
/// the window.
/// Found points must lie within kRecallRadius_px of the prediction and agree on its error: an error of the predicted
/// pose shifts all points alike, so the median shift is taken as the true one.
/// When full, the track lost longest ago is forgotten. No heap. Thread-bound.
class DormantTracks {
public:
    void configure(const StereoRig& rig);

    int size() const { return static_cast<int>(dormant_.size()); }

    /// Forgets all; the tracker's slots are not freed.
    void clear() { dormant_.clear(); }

    /// Takes over a lost track with its template slot. @param q_B0_B  body now to any fixed frame, by the gyroscope
    void add(const Track& track, const Eigen::Quaterniond& q_B0_B, FeatureEngine& engine);

    /// Frees the slot of the track lost longest ago; false if there are no dormant tracks.
    bool forget_oldest(FeatureEngine& engine);

    /// Forgets tracks whose landmarks are not among the predictions (sorted by id), because the smoother has dropped
    /// them.
    void forget_unknown(std::span<const LandmarkPrediction> predictions, FeatureEngine& engine);

    /// A new keyframe was made; none of these tracks is in it.
    void leave_keyframe();

    /// Searches the image for predicted landmarks and moves the tracks it finds to `tracks`, which may grow to `most`.
    void recall(const ImagePyramid& image, std::span<const LandmarkPrediction> predictions,
                const Eigen::Quaterniond& q_B0_B, int most, FeatureEngine& engine, TrackList& tracks);

private:
    struct Dormant {
        Track track;
        Eigen::Quaterniond q_B0_B;  ///< at the time it was lost
    };
    struct Found {
        std::size_t index;
        Track track;
        Eigen::Vector2d shift;  ///< from the prediction (px)
    };
    double median_shift(int axis);
    void erase(std::size_t index) { dormant_.erase(dormant_.begin() + static_cast<std::ptrdiff_t>(index)); }

    Eigen::Quaterniond q_C_B_ = Eigen::Quaterniond::Identity();
    boost::container::static_vector<Dormant, kMaxDormantTracks> dormant_;  ///< longest lost first
    boost::container::static_vector<Found, kMaxDormantTracks> found_;
    boost::container::static_vector<double, kMaxDormantTracks> values_;
};

}  // namespace facet
