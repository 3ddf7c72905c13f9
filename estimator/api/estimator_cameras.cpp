// SPDX-License-Identifier: BSD-2-Clause
// Which camera plays the left one, and what the estimator does when one of them is silent.
#include "estimator/api/estimator_impl.h"

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
RigCalibration exchange(const RigCalibration& c, const StereoRig& given) {
    const Se3 T_B_C0 = c.T_B_Bc * given.T_B_C0;
    const Se3 T_B_C1 = c.T_B_Bc * c.T_Bc_C1(given.T_B_C1);
    RigCalibration out;
    out.time_offset_s = c.time_offset_s;
    out.lens = {c.lens[1], c.lens[0]};
    out.T_B_Bc = T_B_C1 * given.T_B_C1.inverse();
    const Se3 T_Bc_C0 = out.T_B_Bc.inverse() * T_B_C0;
    out.right.q = (given.T_B_C0.q.conjugate() * T_Bc_C0.q).normalized();
    out.right.p = T_Bc_C0.p - given.T_B_C0.p;
    return out;
}

}  // namespace

StereoFrame Estimator::Impl::in_roles(const StereoFrame& frame) const {
    return is_exchanged ? StereoFrame{frame.stamp, frame.right, frame.left, frame.is_by_stamps} : frame;
}

bool Estimator::Impl::is_alone(const StereoFrame& seen) const {
    return seen.right.empty() && (!rig.has_right || (seen.stamp - last_pair).seconds() > kAlone_s);
}

bool Estimator::Impl::misses_camera(Timestamp image) const {
    return rig.has_right && has_frame && (image - last_pair).seconds() > kOneCameraAfter_s;
}

StereoFrame Estimator::Impl::choose_camera(const StereoFrame& frame) {
    StereoFrame seen = in_roles(frame);
    if (!has_frame) {
        has_frame = true;
        last_pair = frame.stamp;
    }
    const bool is_silent = !has_primary || (frame.stamp - last_primary).seconds() > kExchangeAfter_s;
    if (rig.has_right && seen.left.empty() && !seen.right.empty() && is_silent) {
        exchange_cameras();
        seen = in_roles(frame);
    }
    if (!seen.left.empty()) {
        has_primary = true;
        last_primary = frame.stamp;
    }
    if (!seen.left.empty() && !seen.right.empty()) {
        last_pair = frame.stamp;
    }
    return seen;
}

Status Estimator::Impl::pass_over(const StereoFrame& frame, Timestamp stamp, Estimate& estimate) {
    last_image = frame.stamp;
    if (has_window(phase)) {
        carry_to(stamp);
        has_carried = false;
        estimate = carried;
        return Status::kOk;
    }
    is_blind = true;
    report(frame, false, estimate);
    is_blind = false;
    return Status::kOk;
}

void Estimator::Impl::exchange_cameras() {
    take_waiting();
    const RigCalibration corrections_now = exchange(window.calibration(), rig);
    rig = rig.exchanged();
    is_exchanged = !is_exchanged;
    frontend.swap(other_frontend);
    frontend.reset();
    q_Bf_B.setIdentity();
    window.change_rig(rig, corrections_now);
    configure_starts();
    forget_corrections();
    if (config.calibration.estimate_cameras) {
        corrections.right = corrections_now.right;
        corrections.lens = corrections_now.lens;
        frontend.correct_cameras(corrections);
    }
    if (has_window(phase)) {
        phase = Phase::kCoasting;  // until a window begins with the other camera
    }
}

RigCalibration Estimator::Impl::calibration_as_given() const {
    return is_exchanged ? exchange(window.calibration(), rig) : window.calibration();
}

CalibrationEstimate Estimator::calibration() const {
    CalibrationEstimate estimate;
    estimate.correction = impl_->calibration_as_given();
    estimate.correction.time_offset_s = impl_->image_delay_s();
    for (int i = 0; i < impl_->config.calibration.dim() && impl_->window.has_factor(); ++i) {
        estimate.sigma(i) = impl_->window.calibration_sigma(i);
    }
    if (impl_->is_exchanged) {
        estimate.sigma.segment<kLensDim>(kLeftLens).swap(estimate.sigma.segment<kLensDim>(kRightLens));
    }
    return estimate;
}

void Estimator::Impl::configure_starts() {
    motion_start.configure(rig, config.imu_noise, gravity_m_per_s2, config.window.pixel_sigma_px);
    // Twice the sigma of a sighting: its error repeats from keyframe to keyframe, and the lens is not exact.
    monocular_start.configure(rig.T_B_C0, config.imu_noise, gravity_m_per_s2,
                              2.0 * config.window.pixel_sigma_px / rig.left.focal_px());
}

}  // namespace facet
