// SPDX-License-Identifier: BSD-2-Clause
// What works on pixels for the front-end: corners, tracks and stereo matches, by our own code or by OpenCV.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>

#include "estimator/frontend/detector.h"
#include "estimator/frontend/frontend_config.h"
#include "estimator/frontend/image_pyramid.h"
#include "estimator/frontend/stereo_matcher.h"
#include "estimator/frontend/track.h"
#include "estimator/frontend/tracker.h"
#include "estimator/geometry/stereo_rig.h"
#include "platform/base/status.h"

namespace facet {

/// A point of the left image to be found in the right one.
struct StereoQuery {
    Eigen::Vector2d left_uv = Eigen::Vector2d::Zero();  ///< distorted pixel
    double known_inverse_depth = -1.0;                  ///< 1/m, or negative to search
};

/// The parts of the front-end that FrontendConfig::backend chooses; all decisions on their results are the front-end's.
/// Every frame: begin_frame, follow for each earlier image, detect and start at keyframes, begin_right and match if
/// there is a right image.
/// Deterministic. Thread-bound. Heap, and what it costs: see the implementations.
class FeatureEngine {
public:
    FeatureEngine() = default;
    virtual ~FeatureEngine() = default;
    FeatureEngine(const FeatureEngine&) = delete;
    FeatureEngine& operator=(const FeatureEngine&) = delete;

    virtual Status configure(const FrontendConfig& config, const StereoRig& rig) = 0;
    /// Forgets all tracks.
    virtual void reset() = 0;
    /// The calibration as it is known now; configure() forgets it.
    virtual void correct(const CameraCorrections& corrections) = 0;

    /// The next left image; the one before it becomes the previous one.
    virtual void begin_frame(const ImagePyramid& left) = 0;
    virtual void begin_right(const ImagePyramid& right) = 0;

    /// As Detector::detect.
    virtual void detect(const ImagePyramid& left, const PixelMask& mask, Timestamp now,
                        std::span<const Eigen::Vector2d> occupied, int wanted, CornerList& corners) = 0;
    /// As Tracker::start and stop.
    virtual Status start(const ImagePyramid& left, const Eigen::Vector2d& uv, Track& track) = 0;
    virtual void stop(const Track& track) = 0;
    /// From how many frames ago tracks can be followed, at most kMaxTurns.
    virtual int reach() const = 0;
    /// Moves tracks from an earlier image, in which they were seen, to the present one.
    /// @param followed  1 for those found; the others are untouched
    virtual void follow(const ImagePyramid& earlier, const ImagePyramid& present, const FrameMotion& motion,
                        std::span<Track> tracks, std::span<std::uint8_t> followed) = 0;
    /// As Tracker::find_again.
    virtual Status find_again(const ImagePyramid& left, const LandmarkPrediction& prediction,
                              const Eigen::Quaterniond& q_C_Cl, Track& track, Eigen::Vector2d& shift) = 0;
    /// Finds points in the right image.
    /// @param usual_inverse_depth  the tracks' median (1/m), 0 if unknown: for engines that do not search the curve
    /// @param found  1 for those with a match; the others' are untouched
    virtual void match(const ImagePyramid& left, const ImagePyramid& right, std::span<const StereoQuery> queries,
                       double usual_inverse_depth, std::span<StereoMatch> matches, std::span<std::uint8_t> found) = 0;
};

/// Whether this build has the engine that stands on OpenCV. Reentrant.
bool has_opencv_engine();
/// nullptr if it has not. Heap.
std::unique_ptr<FeatureEngine> make_opencv_engine();
/// Heap.
std::unique_ptr<FeatureEngine> make_patch_engine();

}  // namespace facet
