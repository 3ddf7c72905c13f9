// SPDX-License-Identifier: BSD-2-Clause
// The window as a least-squares problem: cost and reduced normal equations at the current states.
#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include "estimator/geometry/square_histogram.h"
#include "estimator/solver/landmark_schur.h"
#include "estimator/solver/levenberg.h"
#include "estimator/values/nav_state.h"
#include "estimator/values/stage.h"
#include "estimator/window/calibration_config.h"
#include "estimator/window/range_config.h"
#include "estimator/window/regularity_config.h"
#include "estimator/window/window_cameras.h"
#include "estimator/window/window_state.h"

namespace facet {

/// How well the window fits, at its last linearization.
struct WindowFit {
    int active_landmarks = 0;
    int vision_rows = 0;                    ///< scalar residuals of active landmarks minus three per landmark
    double vision_squared_error_px2 = 0.0;  ///< not robust, but no observation counts for more than kBlunderPx
    LossSums vision_loss;                   ///< of all observations of active landmarks
    SquareHistogram vision_squares_px2;     ///< squared residual of each camera
    /// Sums of weight times residual, left u and v, right u and v, and of the weights of either camera.
    Eigen::Vector4d weighted_residual_px = Eigen::Vector4d::Zero();
    Eigen::Vector2d weights = Eigen::Vector2d::Zero();

    /// Robust standard deviation of a coordinate: for normal errors the squared residual of a point has the median
    /// 2 ln 2 sigma^2. The landmarks' own freedom, which makes residuals smaller than errors, is allowed for. 0 without
    /// any. [Rousseeuw87]
    double vision_scale_px() const {
        const double points = vision_loss.points;
        return vision_rows > 0
                   ? std::sqrt(vision_squares_px2.median() / (2.0 * std::numbers::ln2) * 2.0 * points / vision_rows)
                   : 0.0;
    }

    /// Squared residual per degree of freedom, in units of this standard deviation; 0 without any.
    double vision_chi2(double sigma_px) const {
        return vision_rows > 0 ? vision_squared_error_px2 / (sigma_px * sigma_px * vision_rows) : 0.0;
    }
};

/// The weights that the robust loss gave either camera of a landmark's observations.
struct ObservationWeights {
    int count = 0;  ///< of observations; 0: none are known
    std::array<Eigen::Vector2f, kMaxKeyframes> weights;

    std::span<const Eigen::Vector2f> known() const { return {weights.data(), static_cast<std::size_t>(count)}; }
};

/// Structureless window problem: prior, inertial factors, and landmarks that are triangulated again and eliminated at
/// each linearization. At a candidate the points follow their cameras by one step with the weights of the states that
/// it was computed from, as its system did: where a step moves points in the images by more than their noise, as along
/// a scale of which little is known, weights at the old points would take all sightings for outliers, and the candidate
/// for a failure. Satisfies the Problem concept of levenberg(). Thread-bound. No heap.
class WindowProblem {
public:
    /// Limit on a residual in WindowFit: what is farther off is a blunder, left to the next outlier removal (px).
    static constexpr double kBlunderPx = 10.0;

    /// The arguments must outlive the problem.
    void bind(WindowState& state, WindowCameras& cameras, const CalibrationConfig& calibration,
              const RegularityConfig& regularity, const RangeConfig& range);
    void set_stage_observer(StageObserver* observer) { observer_ = observer; }

    /// Decides which landmarks take part: seen by two keyframes or more and triangulated. Call before levenberg().
    void select_landmarks();

    double linearize(ReducedSystem& system);
    double linearize_gradient(ReducedSystem& system);
    Status solve(ReducedSolver& solver, const ReducedSystem& system, double lambda);
    Status solve_again(ReducedSolver& solver, const ReducedSystem& system);
    void save();
    void apply(const ReducedSolver::Step& step);
    void restore();

    /// Linearizes only the terms of the oldest keyframe: prior, its inertial factor, and the landmarks marked in
    /// `is_selected` (all must be seen by it). Used by marginalization.
    double linearize_oldest(ReducedSystem& system, const std::array<bool, kMaxLandmarks>& is_selected);

    /// Linearizes only the terms that connect one keyframe to its neighbours without images: prior, inertial and rest
    /// factors.
    double linearize_inertial(ReducedSystem& system, int keyframe);

    /// Cameras and observations at the present states and calibration.
    void refresh();

    /// Of the last linearization of the whole window that was not undone by restore().
    const WindowFit& fit() const { return fit_; }
    /// Parameters that all keyframes share: calibration, ground and planes.
    int globals() const { return plane_row(static_cast<int>(state_->planes.size())); }
    /// First row of a plane's parameters.
    int plane_row(int plane) const { return ground_row() + state_->ground_dim() + kPlaneDim * plane; }
    /// Row of the first level of the ground.
    int ground_row() const { return calibration_config_->dim(); }

private:
    /// Adds all terms to an empty system. @return the cost
    double add_all(ReducedSystem& system);
    /// Adds the calibration's part of the vision terms, which so far contain poses only: the calibration moves the
    /// poses, so with G_k = RigCalibration::d_pose, H_gk = sum_j G_j^T H_jk, H_gg = sum_jk G_j^T H_jk G_k,
    /// g_g = sum_k G_k^T g_k.
    void add_calibration(ReducedSystem& system) const;
    double add_plane_height(Landmark& landmark);
    /// Adds the constraints between planes, and between planes and gravity.
    double add_planes(ReducedSystem& system) const;
    /// Adds what a range finder has found under a keyframe.
    double add_ground(ReducedSystem& system, int keyframe) const;
    double add_prior(ReducedSystem& system);
    /// Adds what the calibration as given says of its corrections.
    double add_given_calibration(ReducedSystem& system) const;
    /// Adds the terms that connect a keyframe to the one before it without images: inertial and rest factor.
    double add_link(ReducedSystem& system, int keyframe) {
        return add_imu(system, keyframe) + add_rest(system, keyframe);
    }
    double add_imu(ReducedSystem& system, int keyframe);
    /// Adds the part of an inertial factor that belongs to the scale of the IMU's axes.
    void add_imu_scale(const ImuFactorLinearization& linearization, int keyframe, ReducedSystem& system) const;
    double add_rest(ReducedSystem& system, int keyframe);
    /// @param weights  that its point follows with, and that become those of this linearization; nullptr: the robust
    ///                 loss decides
    double add_landmark(ReducedSystem& system, Landmark& landmark, ObservationWeights* weights);
    Status linearize_measurements(const Landmark& landmark, bool with_matrix);
    Status eliminate_landmark(const Landmark& landmark, ReducedSystem& system);
    double measure_fit(Landmark& landmark);
    /// To be called before the first and after the last landmark.
    void begin_landmarks(const ReducedSystem& system);
    void end_landmarks(ReducedSystem& system) const;

    WindowState* state_ = nullptr;
    WindowCameras* cameras_ = nullptr;
    const CalibrationConfig* calibration_config_ = nullptr;
    const RegularityConfig* regularity_config_ = nullptr;
    const RangeConfig* range_config_ = nullptr;
    StageObserver* observer_ = nullptr;
    WindowFit fit_;
    LandmarkSchur schur_;
    CameraTermSums camera_sums_;
    std::array<ObservationWeights, kMaxLandmarks> weights_;  ///< at the last linearization, in order of landmarks
    std::array<NavState, kMaxKeyframes> saved_;
    WindowFit saved_fit_;
    RigCalibration saved_calibration_;
    std::array<GroundLevel, PriorFactor::kMaxGround> saved_ground_;
    std::array<Plane, kMaxPlanes> saved_planes_;
    std::array<LandmarkFit, kMaxLandmarks> saved_landmarks_;
    std::array<ObservationWeights, kMaxLandmarks> saved_weights_;
    Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxSystemDim, 1> prior_displacement_;
    Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxSystemDim, 1> prior_gradient_;
};

}  // namespace facet
