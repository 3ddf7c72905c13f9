// SPDX-License-Identifier: BSD-2-Clause
// Inputs and outputs of the front-end: plain values.
#pragma once

#include <Eigen/Geometry>
#include <boost/container/static_vector.hpp>
#include <cstdint>
#include <span>

#include "estimator/values/capacity.h"
#include "estimator/values/health.h"
#include "estimator/values/observation.h"
#include "platform/base/timestamp.h"

namespace facet {

/// Says where the smoother expects its landmarks in the frame.
class LandmarkSource {
public:
    /// All of them, by increasing id; valid until the frame is done.
    virtual std::span<const LandmarkPrediction> predict() = 0;

protected:
    ~LandmarkSource() = default;
};

/// What is known about a frame before looking at it.
struct FrameHints {
    Eigen::Quaterniond q_Bp_B = Eigen::Quaterniond::Identity();  ///< body now to the previous frame: p_Bp = q * p_B
    bool is_replaced = false;  ///< q_Bp_B is not the gyroscope's, whose readings are suspected; q_Bp_B_as_read is
    Eigen::Quaterniond q_Bp_B_as_read = Eigen::Quaterniond::Identity();
    LandmarkSource* landmarks = nullptr;  ///< asked only at keyframes and where tracks are lost; nullptr: none
    bool wants_keyframe = false;          ///< inertial data are poor: vision has to say where the vehicle is
    bool is_starting = false;             ///< nobody knows the gyroscope's bias yet: its turns judge nothing
    bool is_uncertain = false;            ///< something was wrong before: every track counts
    bool is_contradicted = false;         ///< images and inertial readings disagree
    bool replaces_both = false;           ///< both the gyroscope and the accelerometer, neither of which hangs
    bool wants_turn = false;              ///< FrontendOutput::turn_B is asked for
    double effort = 1.0;  ///< share of the configured number of features that a keyframe is filled up to
};

/// Whether an image can be tracked.
enum class ImageState : std::uint8_t {
    kUsable,
    kDark,         ///< hardly anything but black
    kOverexposed,  ///< hardly anything but white
    kFlat,         ///< no contrast
    kFrozen,       ///< the previous image again, although the vehicle turned
};

/// The front-end's result for one frame. Observations are filled at every frame; right ones only at keyframes.
struct FrontendOutput {
    Timestamp stamp;
    ImageState image = ImageState::kUsable;  ///< otherwise nothing was tracked, and there is no keyframe
    bool is_keyframe = false;
    bool is_still = false;             ///< rest_disparity_px below the still threshold
    double median_disparity_px = 0.0;  ///< since the last keyframe, rotation compensated (px)
    double rest_disparity_px = 0.0;    ///< the same or the plain one, whichever is less (px): small at rest
    int tracked = 0;                   ///< tracks carried over from the previous frame
    int lost = 0;      ///< tracks lost in this frame: left the image, failed forward-backward, or outliers
    int recalled = 0;  ///< tracks found again where the smoother predicted them
    int outliers = 0;  ///< of those lost, rejected by the geometric tests
    int detected = 0;  ///< new tracks begun in this frame
    int stereo = 0;    ///< observations with a right match
    bool has_turn = false;
    Timestamp turn_begin;  ///< of the image from which on turn_B counts: one or two frames ago
    Eigen::Vector3d turn_B = Eigen::Vector3d::Zero();  ///< by which images have turned; needs no gyroscope
    double fixed_share = 0.0;                          ///< of the image, left out because it moves with the vehicle
    bool shows_dots = false;  ///< most tracks are on an emitter's dots: Frontend::take_out_dots() is called for
    boost::container::static_vector<FeatureObservation, kMaxFeatures> observations;
    /// After Frontend::match_surface(): corners between the tracks that have a right match. They are not tracked, and
    /// the smoother does not see them; their ids differ from those of all tracks.
    boost::container::static_vector<FeatureObservation, kMaxSurfacePoints> surface;

    /// Fills the fields of the health that come from images.
    void report(Health& health) const {
        health.is_keyframe = is_keyframe;
        health.tracked = tracked;
        health.detected = detected;
        health.stereo = stereo;
        health.recalled = recalled;
        health.outliers = outliers;
        health.fixed_share = fixed_share;
    }
};

}  // namespace facet
