// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/flight/camera_roles.h"

namespace facet {
namespace {

// When the camera that is tracked in has been silent for this long and the other one has not, they exchange their
// roles: longer than any dropped frame, short enough for the inertial prediction to be good to centimetres.
constexpr double kExchangeAfter_s = 0.3;
// A window may begin with one camera when there has been no pair for this long.
constexpr double kAlone_s = 0.3;
// From when on a missing camera is a state of its own.
constexpr double kOneCameraAfter_s = 1.0;

/// The same corrections for the same cameras, left and right exchanged: poses stay where they are.
RigCalibration exchanged(const RigCalibration& c, const StereoRig& given) {
    const Se3 T_B_C0 = c.T_B_Bc * given.T_B_C0;
    const Se3 T_B_C1 = c.T_B_Bc * c.T_Bc_C1(given.T_B_C1);
    RigCalibration out;
    out.time_offset_s = c.time_offset_s;
    out.lens = {c.lens[1], c.lens[0]};
    out.imu = c.imu;
    out.T_B_Bc = T_B_C1 * given.T_B_C1.inverse();
    const Se3 T_Bc_C0 = out.T_B_Bc.inverse() * T_B_C0;
    out.right.q = (given.T_B_C0.q.conjugate() * T_Bc_C0.q).normalized();
    out.right.p = T_Bc_C0.p - given.T_B_C0.p;
    return out;
}

}  // namespace

StereoFrame CameraRoles::in_roles(const StereoFrame& frame) const {
    return is_exchanged_ ? StereoFrame{frame.stamp, frame.right, frame.left, frame.is_by_stamps} : frame;
}

bool CameraRoles::must_exchange(const StereoFrame& frame) const {
    const StereoFrame seen = in_roles(frame);
    const bool is_silent = !last_primary_ || (frame.stamp - *last_primary_).seconds() > kExchangeAfter_s;
    return rig_.has_right && seen.left.empty() && !seen.right.empty() && is_silent;
}

RigCalibration CameraRoles::exchange(const RigCalibration& corrections) {
    RigCalibration out = exchanged(corrections, rig_);
    rig_ = rig_.exchanged();
    is_exchanged_ = !is_exchanged_;
    return out;
}

RigCalibration CameraRoles::as_given(const RigCalibration& corrections) const {
    return is_exchanged_ ? exchanged(corrections, rig_) : corrections;
}

StereoFrame CameraRoles::step(const StereoFrame& frame) {
    const StereoFrame seen = in_roles(frame);
    const bool is_pair = !seen.left.empty() && !seen.right.empty();
    if (is_pair || !last_pair_) {
        last_pair_ = frame.stamp;
    }
    if (!seen.left.empty()) {
        last_primary_ = frame.stamp;
    }
    return seen;
}

bool CameraRoles::is_alone(const StereoFrame& seen) const {
    return seen.right.empty() && (!rig_.has_right || !last_pair_ || (seen.stamp - *last_pair_).seconds() > kAlone_s);
}

bool CameraRoles::misses_camera(Timestamp image) const {
    return rig_.has_right && last_pair_ && (image - *last_pair_).seconds() > kOneCameraAfter_s;
}

}  // namespace facet
