// SPDX-License-Identifier: BSD-2-Clause
// The window as a least-squares problem: cost and reduced normal equations at the current states.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "estimator/geometry/stereo_rig.h"
#include "estimator/solver/landmark_schur.h"
#include "estimator/solver/levenberg.h"
#include "estimator/values/nav_state.h"
#include "estimator/values/stage.h"
#include "estimator/window/calibration_config.h"
#include "estimator/window/regularity_config.h"
#include "estimator/window/stereo_views.h"
#include "estimator/window/vision_noise.h"
#include "estimator/window/window_config.h"
#include "estimator/window/window_state.h"

namespace facet {

/// How well the window fits, at its last linearization.
struct WindowFit {
    int active_landmarks = 0;
    int vision_rows = 0;                    ///< scalar residuals of active landmarks minus three a landmark
    double vision_squared_error_px2 = 0.0;  ///< not robust, but that no observation counts for more than kBlunderPx
    LossSums vision_loss;                   ///< of all observations of active landmarks
};

/// Structureless window problem: prior, inertial factors, and landmarks that are triangulated anew and eliminated at each
/// linearization. Fulfils the Problem concept of levenberg(). Thread-bound. No heap.
class WindowProblem {
public:
    /// Standard deviation of the prior on inverse depth (1/m): weak against any real baseline, holds points without one.
    static constexpr double kRhoPriorSigma = 3.0;
    /// What is farther off is one blunder more, however far: the next outlier removal takes it (px).
    static constexpr double kBlunderPx = 10.0;

    /// `state` and the configs must outlive the problem.
    void bind(WindowState& state, const WindowConfig& config, const CalibrationConfig& calibration,
              const RegularityConfig& regularity, const StereoRig& rig);
    void set_stage_observer(StageObserver* observer) { observer_ = observer; }

    /// Decides which landmarks take part: seen by two keyframes or more and triangulated. Call before levenberg().
    void select_landmarks();

    double linearize(ReducedSystem& system);
    Status solve(ReducedSolver& solver, const ReducedSystem& system, double lambda);
    void save();
    void apply(const ReducedSolver::Step& step);
    void restore();

    /// Linearizes only what touches the oldest keyframe: prior, its inertial factor, and the landmarks that
    /// `is_selected` names (all must be seen by it). Used by marginalization.
    double linearize_oldest(ReducedSystem& system, const std::array<bool, kMaxLandmarks>& is_selected);

    /// Linearizes only what ties one keyframe to its neighbours without images: prior, inertial and rest factors.
    double linearize_inertial(ReducedSystem& system, int keyframe);

    /// Camera poses at the current states; refreshed by update_cameras().
    const CameraPose& left_camera(int keyframe) const { return cameras_[static_cast<std::size_t>(keyframe)].left; }
    const CameraPose& right_camera(int keyframe) const { return cameras_[static_cast<std::size_t>(keyframe)].right; }
    /// How a keyframe's cameras see the chart of landmarks first seen by `host`, host <= keyframe.
    const StereoView& view(int keyframe, int host) const { return views_.at(keyframe, host); }
    void update_cameras();

    /// Triangulates a landmark at the current camera poses; false (and untouched) if it fails.
    /// @param steps  at most, of Gauss-Newton, from the point that is known; one that is not is looked for
    bool triangulate_landmark(Landmark& landmark, int steps) const;

    /// The body's pose (state) turned into its left camera's, with the calibration as it stands.
    CameraPose left_camera_of(const NavState& state) const {
        return CameraPose::from(state.T_W_B() * state_->calibration.T_B_Bc * T_B_C0_);
    }

    const WindowFit& fit() const { return fit_; }
    /// Begins with what the configuration says of observations.
    void reset_noise();
    /// Weights of the next optimization follow the residuals of the last one.
    void learn_noise();
    /// Outliers lose all influence, instead of most of it: once the states are roughly right.
    void set_settled(bool is_settled) {
        is_settled_ = is_settled;
        whiten();
    }
    const VisionNoise& noise() const { return noise_; }
    /// Variance of observations as measured at the last linearization of the whole window, in units of the one they are
    /// weighted with, outliers included, within [0.05, 20]: for tests that ask whether things agree.
    double observation_variance() const {
        return std::clamp(std::pow(noise_.measured_px() / noise_.sigma_px(), 2), 0.05, 20.0);
    }
    const StereoGeometry& geometry() const { return geometry_; }
    /// Standard deviations in a pixel.
    double pixels_to_sigmas() const { return 1.0 / noise_.sigma_px(); }
    /// Parameters that all keyframes share: calibration and planes.
    int globals() const { return plane_row(static_cast<int>(state_->planes.size())); }
    /// First row of a plane's parameters.
    int plane_row(int plane) const { return calibration_config_->dim() + kPlaneDim * plane; }

private:
    /// Body pose at a keyframe's image: its state, moved by what the time offset has changed since.
    Se3 T_W_B_at_image(const Keyframe& keyframe, const NavState& state) const;
    /// Adds the calibration's part of the vision terms, which hold poses only so far: the calibration moves the poses, so
    /// with G_k = RigCalibration::d_pose, H_gk = sum_j G_j^T H_jk, H_gg = sum_jk G_j^T H_jk G_k, g_g = sum_k G_k^T g_k.
    void add_calibration(ReducedSystem& system) const;
    double add_plane_height(Landmark& landmark);
    /// How the planes lie to each other and to gravity.
    double add_planes(ReducedSystem& system) const;
    double add_prior(ReducedSystem& system);
    /// What ties a keyframe to the one before it without images: inertial and rest factor.
    double add_link(ReducedSystem& system, int keyframe) {
        return add_imu(system, keyframe) + add_rest(system, keyframe);
    }
    double add_imu(ReducedSystem& system, int keyframe);
    double add_rest(ReducedSystem& system, int keyframe);
    double add_landmark(ReducedSystem& system, Landmark& landmark);
    void whiten();

    static constexpr double kStartThreshold = 1.5;  ///< of Huber's loss

    WindowState* state_ = nullptr;
    const WindowConfig* config_ = nullptr;
    const CalibrationConfig* calibration_config_ = nullptr;
    const RegularityConfig* regularity_config_ = nullptr;
    StageObserver* observer_ = nullptr;
    StereoGeometry geometry_;
    Se3 T_B_C0_;  ///< as calibrated
    Se3 T_B_C1_;
    WindowFit fit_;
    VisionNoise noise_;
    RobustLoss loss_;
    bool is_settled_ = false;
    double focal_left_px_ = 1.0;
    double focal_right_px_ = 1.0;
    LandmarkSchur schur_;
    std::array<CameraPair, kMaxKeyframes> cameras_;
    StereoViews views_;
    StereoViews views_lin_;  ///< from where Jacobians are taken
    std::array<Eigen::Matrix3d, kMaxKeyframes> R_B_W_lin_;
    std::array<NavState, kMaxKeyframes> saved_;
    RigCalibration saved_calibration_;
    std::array<Plane, kMaxPlanes> saved_planes_;
    Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxSystemDim, 1> prior_displacement_;
    Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxSystemDim, 1> prior_gradient_;
};

}  // namespace facet
