// SPDX-License-Identifier: BSD-2-Clause
// The cameras of the window's keyframes at the present states, and the weight of their observations.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "estimator/geometry/stereo_rig.h"
#include "estimator/values/capacity.h"
#include "estimator/values/nav_state.h"
#include "estimator/values/observation.h"
#include "estimator/window/calibration_config.h"
#include "estimator/window/published_weights.h"
#include "estimator/window/stereo_views.h"
#include "estimator/window/vision_noise.h"
#include "estimator/window/window_config.h"
#include "estimator/window/window_state.h"

namespace facet {

/// Camera poses, the views between them, and the whitening of pixels, shared by all users of landmarks. Poses are those
/// of the last update(), which must be called after states have changed. About 550 kB. Thread-bound. No heap.
class WindowCameras {
public:
    /// What is given must outlive the cameras. The noise starts at the configured value.
    void bind(const WindowState& state, const WindowConfig& config, const CalibrationConfig& calibration,
              const StereoRig& rig);

    /// A feature as an observation by a keyframe, corrected for what is known of the lenses.
    LandmarkObservation observe(int keyframe, const FeatureObservation& feature) const;
    /// Corrects an observation again.
    void correct(LandmarkObservation& observation) const;
    bool estimates_lenses() const { return calibration_->estimate_cameras; }
    /// Whether the lenses have moved by more than kNegligiblePx since this last said so: then all observations are to
    /// be corrected again.
    bool take_lenses();
    /// What whitens the difference of two points, as one camera sees them, near an observation.
    Eigen::Matrix2d whitening_left(const LandmarkObservation& observation) const {
        return geometry_.scale * observation.measurement.d_left_d_xy.cast<double>();
    }
    Eigen::Matrix2d whitening_right(const LandmarkObservation& observation) const {
        return geometry_.scale * observation.measurement.d_right_d_xy.cast<double>();
    }
    /// The Jacobians by parameters of single cameras that an observation has.
    CameraTerms terms(const LandmarkObservation& observation) const {
        return {observation.d_left_d_lens, observation.d_right_d_lens, R_Bc_C1_};
    }
    /// Where a point that the left camera sees at xy appears to the lens as given.
    Eigen::Vector2d given_left_xy(const Eigen::Vector2d& xy) const;

    /// Poses and views at the present states and calibration.
    void update();

    const CameraPose& left(int keyframe) const { return poses_[static_cast<std::size_t>(keyframe)].left; }
    const CameraPose& right(int keyframe) const { return poses_[static_cast<std::size_t>(keyframe)].right; }
    /// How a keyframe's cameras see the chart of landmarks first seen by `host`, host <= keyframe.
    const StereoView& view(int keyframe, int host) const { return views_.at(keyframe, host); }
    /// The same at the poses where Jacobians are evaluated.
    const StereoView& view_lin(int keyframe, int host) const { return views_lin_.at(keyframe, host); }
    const Eigen::Matrix3d& R_B_W_lin(int keyframe) const { return R_B_W_lin_[static_cast<std::size_t>(keyframe)]; }

    /// Left camera of a body in this state, with the present calibration.
    CameraPose left_of(const NavState& state) const {
        return CameraPose::from(state.T_W_B() * state_->calibration.T_B_Bc * rig_.T_B_C0);
    }

    /// Lets the weights follow the residuals measured last.
    void learn_noise();
    /// Takes the residuals of an optimized window; see VisionNoise::measure.
    void measure_noise(double squared_error_px2, int rows, double scale_px, const LossSums& loss) {
        noise_.measure(squared_error_px2, rows, scale_px, loss);
    }
    /// True once the states are roughly right: outliers then lose all influence, instead of most of it.
    void set_settled(bool is_settled);

    const VisionNoise& noise() const { return noise_; }
    /// On a landmark's observations.
    const RobustLoss& loss(const Landmark& landmark) const { return landmark.is_projected ? kProjectionLoss : loss_; }
    const StereoGeometry& geometry() const { return geometry_; }
    /// Number of standard deviations in a pixel.
    double pixels_to_sigmas() const { return 1.0 / noise_.sigma_px(); }
    /// Variance of observations as measured after the last optimization, in units of the variance
    /// they are weighted with, outliers included, clamped to [0.05, 20]: for tests of whether observations agree.
    double observation_variance() const {
        return std::clamp(std::pow(noise_.measured_px() / noise_.sigma_px(), 2), 0.05, 20.0);
    }

private:
    static constexpr RobustLoss kProjectionLoss = PublishedWeights::projection_loss();

    /// What observations may lag behind the lenses, far below their noise (px).
    static constexpr double kNegligiblePx = 1e-3;

    /// Body pose at a keyframe's image: its state, moved by the change of the time offset since.
    Se3 T_W_B_at_image(const Keyframe& keyframe, const NavState& state) const;
    void whiten();

    const WindowState* state_ = nullptr;
    const WindowConfig* config_ = nullptr;
    const CalibrationConfig* calibration_ = nullptr;
    StereoRig rig_;  ///< as given
    std::array<LensCorrection, 2> corrected_lens_{LensCorrection::Zero(), LensCorrection::Zero()};
    Eigen::Matrix3d R_Bc_C1_ = Eigen::Matrix3d::Identity();
    bool is_settled_ = false;
    VisionNoise noise_;
    RobustLoss loss_;
    StereoGeometry geometry_;
    std::array<CameraPair, kMaxKeyframes> poses_;
    StereoViews views_;
    StereoViews views_lin_;
    std::array<Eigen::Matrix3d, kMaxKeyframes> R_B_W_lin_;
};

}  // namespace facet
