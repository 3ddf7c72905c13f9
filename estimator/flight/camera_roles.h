// SPDX-License-Identifier: BSD-2-Clause
// Which camera plays the left one, and which of them are silent.
#pragma once

#include <optional>

#include "estimator/geometry/stereo_rig.h"
#include "estimator/window/rig_calibration.h"
#include "platform/base/samples.h"
#include "platform/base/timestamp.h"

namespace facet {

/// Front-end and window track in the left camera. When that one is silent and the other is not, the two exchange their
/// roles. Usage, for each frame:
///   if (roles.must_exchange(frame)) { corrections = roles.exchange(corrections); ... }
///   const StereoFrame seen = roles.step(frame);
/// Thread-bound. No heap.
class CameraRoles {
public:
    CameraRoles() = default;
    explicit CameraRoles(const StereoRig& rig) : rig_(rig) {}

    /// In the present roles.
    const StereoRig& rig() const { return rig_; }
    /// The right camera plays the left one.
    bool is_exchanged() const { return is_exchanged_; }

    /// The frame is of the other camera alone, and the one that is tracked in has been silent for a while.
    bool must_exchange(const StereoFrame& frame) const;
    /// Exchanges the roles. @param corrections  of the calibration so far @return the same for the new roles
    RigCalibration exchange(const RigCalibration& corrections);
    /// Corrections in the present roles as those of the rig as given.
    RigCalibration as_given(const RigCalibration& corrections) const;

    /// Notes which cameras have given an image. @return the frame in the present roles
    StereoFrame step(const StereoFrame& frame);
    /// Nothing has been seen yet; the roles stay.
    void forget_frames() { last_primary_ = last_pair_ = {}; }

    /// There is one image, and not just because the other was dropped. @param seen  in the present roles
    bool is_alone(const StereoFrame& seen) const;
    /// One of two cameras has been silent for a while. @param image  stamp of the newest frame
    bool misses_camera(Timestamp image) const;

private:
    StereoFrame in_roles(const StereoFrame& frame) const;

    StereoRig rig_;
    bool is_exchanged_ = false;
    std::optional<Timestamp> last_primary_;  ///< the newest image of the camera in the left one's role
    std::optional<Timestamp> last_pair_;     ///< the newest frame with both images, or the first frame
};

}  // namespace facet
