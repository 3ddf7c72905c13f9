// SPDX-License-Identifier: BSD-2-Clause
// The front-end: tracks corners in the left image, matches them in the right one, rejects outliers, picks keyframes.
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <span>

#include "estimator/frontend/frontend_config.h"
#include "estimator/frontend/frontend_types.h"
#include "estimator/geometry/stereo_rig.h"
#include "estimator/values/camera_corrections.h"
#include "platform/base/samples.h"
#include "platform/base/status.h"

namespace facet {

/// Usage: configure once; process every frame in order of time. Thread-bound: one thread at a time, no globals.
/// Deterministic: equal inputs give equal outputs to the bit. Heap: in configure() only; no exceptions.
class Frontend {
public:
    Frontend();
    ~Frontend();
    Frontend(const Frontend&) = delete;
    Frontend& operator=(const Frontend&) = delete;

    /// Allocates all buffers for the rig's image sizes. kInvalidArgument if a field is out of range.
    Status configure(const FrontendConfig& config, const StereoRig& rig);

    /// What each camera sees of the vehicle itself: nothing is taken from where a mask is black (0). An empty view:
    /// nothing is masked. configure() forgets both.
    /// @return kInvalidArgument if a size is not its camera's (that mask and those after it unchanged)
    Status set_masks(const ImageView& left, const ImageView& right);

    /// From now on all images are tracked in without their bright dots (DotFilter), until configure(). Forgets all
    /// tracks, and what was found to move with the vehicle.
    void take_out_dots();

    /// Forgets all tracks; landmark ids go on counting, corrections of the cameras stay.
    void reset();
    /// Whether landmark ids are about to be used up, after weeks: then all tracks must be forgotten by restart_ids().
    bool ids_run_out() const;
    /// Forgets all tracks and counts landmark ids from `first` on: only together with everybody who knows the old ones.
    void restart_ids(std::uint32_t first = 0);
    /// Exchanges two front-ends with all they hold, but for the count of landmark ids. No heap.
    void swap(Frontend& other);

    /// Processes one frame.
    /// @param frame      left image of the rig's size; the right one may be empty: then no stereo matches
    /// @param hints      rotation from the gyroscope, and predictions by the smoother
    /// @param output     filled on kOk; an image that cannot be tracked is kOk too: see FrontendOutput::image
    /// @return kInvalidArgument on a wrong image size or a rotation that is not a unit quaternion, kOutOfOrder if the
    ///         stamp does not increase: the tracks then stay as they were.
    Status process(const StereoFrame& frame, const FrameHints& hints, FrontendOutput& output);

    /// After a keyframe, and before the next frame: finds the right matches of corners between its tracks, which take
    /// as long as a frame but which neither tracks nor smoother wait for. Nothing else changes, and nothing is lost
    /// without it but these points.
    /// @param output  of the last process(); its `surface` is filled, once
    void match_surface(FrontendOutput& output);

    /// What the smoother has found of the cameras' calibration, for stereo matches from the next frame on; configure()
    /// returns to the rig as given. Observations stay those of the lenses as given.
    void correct_cameras(const CameraCorrections& corrections);

    /// Ends the tracks the smoother has judged to be outliers; unknown ids are ignored.
    void drop_tracks(std::span<const LandmarkId> landmarks);

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace facet
