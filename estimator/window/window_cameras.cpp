// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/window_cameras.h"

#include "estimator/window/plain_loss.h"

namespace facet {
namespace {

constexpr double kStartThreshold = 1.5;  // of Huber's loss, until the window has settled

}  // namespace

void WindowCameras::bind(const WindowState& state, const WindowConfig& config, const CalibrationConfig& calibration,
                         const StereoRig& rig) {
    state_ = &state;
    config_ = &config;
    calibration_ = &calibration;
    rig_ = rig;
    is_settled_ = false;
    corrected_lens_ = {LensCorrection::Zero(), LensCorrection::Zero()};
    noise_.reset(config.published_weights ? PublishedWeights::kStructureless_px : config.pixel_sigma_px,
                 config.learn_pixel_sigma);
    whiten();
}

LandmarkObservation WindowCameras::observe(int keyframe, const FeatureObservation& feature) const {
    LandmarkObservation o;
    o.keyframe = keyframe;
    o.measurement.left_xy = feature.left_xy;
    o.measurement.right_xy = feature.right_xy;
    o.measurement.has_right = feature.has_right;
    o.measurement.d_left_d_xy = rig_.left.d_uv_d_xy(feature.left_xy).cast<float>();
    if (feature.has_right) {
        o.measurement.d_right_d_xy = rig_.right.d_uv_d_xy(feature.right_xy).cast<float>();
    }
    if (estimates_lenses()) {
        o.given_left_xy = feature.left_xy;
        o.given_right_xy = feature.right_xy;
        o.d_left_d_lens = d_xy_d_lens(rig_.left, feature.left_xy);
        if (feature.has_right) {
            o.d_right_d_lens = d_xy_d_lens(rig_.right, feature.right_xy);
        }
        correct(o);
    }
    return o;
}

bool WindowCameras::take_lenses() {
    if (!estimates_lenses()) {
        return false;
    }
    double moved_px = 0.0;
    for (std::size_t i = 0; i < 2; ++i) {
        // A point at 45 degrees moves by the focal length times any parameter but the principal point's.
        LensCorrection d = (state_->calibration.lens[i] - corrected_lens_[i]).cwiseAbs();
        d.segment<2>(kLensPrincipal) /= rig_.left.focal_px();
        moved_px += rig_.left.focal_px() * d.sum();
    }
    if (moved_px <= kNegligiblePx) {
        return false;
    }
    corrected_lens_ = state_->calibration.lens;
    return true;
}

void WindowCameras::correct(LandmarkObservation& o) const {
    o.measurement.left_xy = o.given_left_xy + o.d_left_d_lens.cast<double>() * state_->calibration.lens[0];
    if (o.measurement.has_right) {
        o.measurement.right_xy = o.given_right_xy + o.d_right_d_lens.cast<double>() * state_->calibration.lens[1];
    }
}

Eigen::Vector2d WindowCameras::given_left_xy(const Eigen::Vector2d& xy) const {
    return estimates_lenses() ? (xy - d_xy_d_lens(rig_.left, xy).cast<double>() * state_->calibration.lens[0]).eval()
                              : xy;
}

void WindowCameras::learn_noise() {
    if (!config_->published_weights) {
        noise_.learn();
        whiten();
    }
}

void WindowCameras::set_settled(bool is_settled) {
    is_settled_ = is_settled;
    whiten();
}

void WindowCameras::whiten() {
    geometry_.scale = 1.0 / noise_.sigma_px();
    if (config_->published_weights) {
        loss_ = kPlainLoss;
    } else if (is_settled_) {
        loss_ = {config_->loss_threshold * noise_.scale_px() / noise_.sigma_px(), LossKind::kCauchy};
    } else {
        loss_ = {kStartThreshold, LossKind::kHuber};
    }
}

Se3 WindowCameras::T_W_B_at_image(const Keyframe& keyframe, const NavState& state) const {
    const double late_s = state_->calibration.time_offset_s - keyframe.time_offset_s;
    return {(state.q_W_B * so3_exp(late_s * keyframe.w_B)).normalized(), state.p_W_B + late_s * state.v_W_B};
}

void WindowCameras::update() {
    const RigCalibration& calibration = state_->calibration;
    const Se3 T_Bc_C1 = estimates_lenses() ? calibration.T_Bc_C1(rig_.T_B_C1) : rig_.T_B_C1;
    const Se3 T_B_C0 = calibration.T_B_Bc * rig_.T_B_C0;
    const Se3 T_B_C1 = calibration.T_B_Bc * T_Bc_C1;
    R_Bc_C1_ = T_Bc_C1.R();
    geometry_.R_C0_B = T_B_C0.R().transpose();
    geometry_.R_C1_B = T_B_C1.R().transpose();
    geometry_.p_B_C0 = T_B_C0.p;
    geometry_.p_B_C1 = T_B_C1.p;
    for (std::size_t k = 0; k < state_->keyframes.size(); ++k) {
        const Keyframe& keyframe = state_->keyframes[k];
        const auto pair_at = [&](const Se3& T_W_B) -> CameraPair {
            return {CameraPose::from(T_W_B * T_B_C0), CameraPose::from(T_W_B * T_B_C1)};
        };
        const Se3 T_W_B_lin = T_W_B_at_image(keyframe, keyframe.linearization_point());
        R_B_W_lin_[k] = T_W_B_lin.R().transpose();
        poses_[k] = pair_at(T_W_B_at_image(keyframe, keyframe.state));
        views_.set(static_cast<int>(k), poses_[k], poses_);
        views_lin_.set(static_cast<int>(k), pair_at(T_W_B_lin), poses_);
    }
}

}  // namespace facet
