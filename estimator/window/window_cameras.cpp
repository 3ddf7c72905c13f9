// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/window_cameras.h"

namespace facet {
namespace {

constexpr double kStartThreshold = 1.5;  // of Huber's loss, until the window has settled

}  // namespace

void WindowCameras::bind(const WindowState& state, const WindowConfig& config, const StereoRig& rig) {
    state_ = &state;
    config_ = &config;
    T_B_C0_ = rig.T_B_C0;
    T_B_C1_ = rig.T_B_C1;
    focal_left_px_ = rig.left.focal_px();
    focal_right_px_ = rig.right.focal_px();
    is_settled_ = false;
    noise_.reset(config.pixel_sigma_px, config.learn_pixel_sigma);
    whiten();
}

void WindowCameras::learn_noise() {
    noise_.learn();
    whiten();
}

void WindowCameras::set_settled(bool is_settled) {
    is_settled_ = is_settled;
    whiten();
}

void WindowCameras::whiten() {
    geometry_.scale_left = focal_left_px_ / noise_.sigma_px();
    geometry_.scale_right = focal_right_px_ / noise_.sigma_px();
    loss_ = is_settled_ ? RobustLoss{config_->loss_threshold * noise_.scale_px() / noise_.sigma_px(), true}
                        : RobustLoss{kStartThreshold, false};
}

Se3 WindowCameras::T_W_B_at_image(const Keyframe& keyframe, const NavState& state) const {
    const double late_s = state_->calibration.time_offset_s - keyframe.time_offset_s;
    return {(state.q_W_B * so3_exp(late_s * keyframe.w_B)).normalized(), state.p_W_B + late_s * state.v_W_B};
}

void WindowCameras::update() {
    const Se3 T_B_C0 = state_->calibration.T_B_Bc * T_B_C0_;
    const Se3 T_B_C1 = state_->calibration.T_B_Bc * T_B_C1_;
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
