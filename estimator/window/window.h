// SPDX-License-Identifier: BSD-2-Clause
// The fixed-lag window smoother.
#pragma once

#include <optional>
#include <span>

#include "estimator/imu/vibration_share.h"
#include "estimator/values/health.h"
#include "estimator/values/imu_noise.h"
#include "estimator/values/nav_state.h"
#include "estimator/values/observation.h"
#include "estimator/values/residuals.h"
#include "estimator/window/calibration_prior.h"
#include "estimator/window/calibration_quality.h"
#include "estimator/window/marginalization.h"
#include "estimator/window/plane_set.h"
#include "estimator/window/redundancy.h"
#include "estimator/window/residual_bias.h"
#include "estimator/window/window_problem.h"

namespace facet {

class LocalMap;

/// A frame that becomes a keyframe.
struct KeyframeInput {
    Timestamp stamp;                                ///< in the IMU's clock: the image's plus Window's time offset
    Eigen::Vector3d w_B = Eigen::Vector3d::Zero();  ///< rate at the stamp, bias subtracted (rad/s)
    bool rests_since_previous = false;              ///< by images and inertial samples: the vehicle stood still
    std::span<const FeatureObservation> observations;
    bool images_rest = false;  ///< by images alone: they have not moved since the previous keyframe
    /// What the keyframe's own image shows of its state: the optimization begins there, and need not take a second
    /// matrix. nullptr: it begins where inertial samples lead.
    const NavState* guess = nullptr;
    /// A point of the ground under the vehicle, in B, by a range finder (m).
    std::optional<Eigen::Vector3d> ground_B = std::nullopt;
    double climb_sigma_m_per_s = 0.0;  ///< of the vertical speed since the previous keyframe
};

/// Summary of one optimization.
struct WindowSummary {
    LevenbergSummary solver;
    WindowFit fit;
    double imu_squared_error = 0.0;  ///< whitened squared residual (15 rows) of the newest inertial factor
    int newest_landmarks = 0;        ///< landmarks that constrain the newest keyframe, without outliers
    int rejected_observations = 0;   ///< removed as outliers afterwards
    int rejected_landmarks = 0;      ///< landmarks whose newest observation was one: their tracks should end
    bool marginalization_failed = false;
    bool prior_replaced = false;  ///< the system had no solution with the prior as it was
};

/// What a window that begins holds of the calibration.
enum class CalibrationStart : std::uint8_t {
    kAsGiven,  ///< what was estimated is forgotten
    kAsKnown,  ///< estimates and their covariance go on, unless they are beyond belief
};

/// Fixed-lag smoother over keyframe states [theta p v bg ba] with structureless stereo landmarks, inertial factors and
/// a prior. Usage: configure; start with the first keyframe; then add_keyframe and optimize for each following one.
/// About 30 MB, no heap after construction: allocate it once. Thread-bound. Deterministic.
class Window {
public:
    void configure(const WindowConfig& config, const CalibrationConfig& calibration, const StereoRig& rig,
                   const ImuNoise& noise, const RegularityConfig& regularity = {}, const RangeConfig& range = {});
    void set_stage_observer(StageObserver* observer);
    /// Goes on with the same cameras in other roles: forgets keyframes, landmarks, planes, prior and learned weights,
    /// not the residuals counted so far. start() must follow. No heap.
    /// @param calibration  the corrections so far, in the new roles
    void change_rig(const StereoRig& rig, const RigCalibration& calibration);

    /// To be called after configure(): what an earlier run has found of the calibration, with which the first start()
    /// with kAsKnown begins. Its correlations are not known, so that twice the standard deviations are believed.
    /// @return kInvalidArgument if a parameter that is estimated has no finite value, or no standard deviation > 0
    ///         (nothing changed)
    Status resume_calibration(const RigCalibration& correction, const RigCalibration::Tangent& sigma);

    /// Forgets keyframes, landmarks and prior, and begins with one keyframe and its Gaussian prior.
    /// @param information  15x15, order [theta p v bg ba], about `state`
    void start(const KeyframeInput& input, const NavState& state,
               const Eigen::Matrix<double, kStateDim, kStateDim>& information,
               CalibrationStart calibration = CalibrationStart::kAsGiven);
    /// The next start begins with the calibration as given.
    void forget_calibration();

    /// Appends a keyframe predicted from the newest one by `preintegration`. If the window is full, room is made
    /// first: the keyframe before the three newest is dropped if it adds nothing to the one before it (RedundancyTest);
    /// otherwise the oldest one is marginalized.
    /// @return kDegenerate if the preintegration spans no time (window untouched).
    Status add_keyframe(const KeyframeInput& input, const Preintegration& preintegration);

    /// Sets the planes that the mesh has found; every optimize() uses them until the next call or start(). Has no
    /// effect in mode S.
    void set_planes(const PlaneProposals& proposals) { proposals_ = proposals; }

    /// Bounded optimization of the whole window, then removal of outliers.
    /// @param effort  scales the configured number of iterations; at least one is made
    WindowSummary optimize(double effort = 1.0);

    /// Whether a range finder's readings were found not to be those of level ground; for as many keyframes as the
    /// window has, none is used then.
    bool doubts_ground() const { return ground_doubt_ > 0; }

    /// Landmarks whose newest observation optimize() has just rejected.
    std::span<const LandmarkId> rejected() const { return {rejected_.data(), rejected_.size()}; }

    /// Marginal covariance of the newest keyframe's state after optimize(), 15x15, order [theta p v bg ba], of the
    /// error in the tangent space of the estimate. @return kDegenerate if the window's information is singular (output
    /// untouched).
    Status newest_covariance(Eigen::Matrix<double, kStateDim, kStateDim>& covariance);

    /// What the optimization has left of the newest inertial factor; to be called after newest_covariance().
    /// @return kNotFound without such a factor, kDegenerate without a factorization (output untouched)
    Status newest_innovation(InertialInnovation& innovation) const;

    /// What the newest keyframe knows of its landmarks, for the frames after it; to be called after
    /// newest_covariance().
    /// @return kDegenerate if the window has not been optimized or does not determine the newest state (map empty)
    Status fill_map(LocalMap& map) const;

    /// Where the landmarks should appear to the left camera of a body in this state; by increasing id. Valid until the
    /// next non-const call.
    std::span<const LandmarkPrediction> predict_landmarks(const NavState& state);

    using CamerasCovariance = Eigen::Matrix<double, kCameraTermsDim, kCameraTermsDim>;

    /// Corrections of the calibration so far.
    const RigCalibration& calibration() const { return state_.calibration; }
    /// Standard deviation of a calibration parameter (kTimeOffset, ...) after newest_covariance(); 0 if not estimated.
    double calibration_sigma(int parameter);
    /// What the standard deviations of the given calibration have to be multiplied by, by what has been seen.
    double calibration_scale() const { return quality_.scale(); }
    /// Largest correction of a parameter of the calibration, in standard deviations of what was given; 0 if none is
    /// estimated.
    double calibration_stretch() const;
    /// Largest mean of the residuals of an image coordinate (px); 0 until enough has been seen.
    double residual_bias_px() const { return residual_bias_.largest_px(); }
    /// Covariance of the parameters of single cameras, in the order of CameraTerms, after newest_covariance(); only if
    /// they are estimated.
    const CamerasCovariance& cameras_covariance() {
        if (!has_cameras_covariance_) {
            cameras_covariance_ = workspace_.solver.cameras_covariance(kRigDim);
            has_cameras_covariance_ = true;
        }
        return cameras_covariance_;
    }

    /// Fills the window's fields of the health. @param summary  of its last optimization; empty before the first one
    void report(const WindowSummary& summary, Health& health) const;

    /// Whether the solver holds a factor of the last optimization, which calibration_sigma() needs.
    bool has_factor() const { return is_factorized_; }

    /// Residuals of the keyframes that have left since configure().
    const VisionResiduals& residuals() const { return residuals_; }

    bool empty() const { return state_.keyframes.empty(); }
    const Keyframe& newest() const { return state_.keyframes.back(); }
    const WindowState& state() const { return state_; }
    /// Cameras of the keyframes, and how residuals are whitened.
    const WindowCameras& cameras() const { return cameras_; }

    /// Replaces keyframe k's inertial factor by one integrated at another bias. @return kDegenerate if refused
    /// (untouched).
    Status replace_imu_factor(int keyframe, const Preintegration& preintegration);

private:
    /// Takes the calibration as given for a rig.
    void believe_given(const StereoRig& rig);
    /// Sets what a new window begins with of the calibration: its estimate, what was given of it, and, returned, the
    /// prior's information about the estimate.
    CalibrationMatrix begin_calibration(CalibrationStart start);
    /// Information about the estimated calibration, of the window so far or of an earlier run.
    /// @return whether there is any
    bool known_information(CalibrationMatrix& information);
    /// Information about the calibration, if it is as good as has been learnt.
    CalibrationMatrix scaled_given() const;
    /// Judges from the last optimization how good the given calibration is.
    void learn_calibration_quality();
    /// Lets the calibration in the prior wander up to a time.
    void let_calibration_wander(Timestamp stamp);
    void make_room();
    /// Gives a window that has lost its prior one on its oldest keyframe, and on others that no inertial factor ties to
    /// the one before.
    void replace_prior();
    /// Sets the calibration's share of a new prior, about the present calibration.
    void fill_calibration_prior(const CalibrationMatrix& information);
    void add_ground(const KeyframeInput& input);
    void choose_factors();
    void add_observations(int keyframe, std::span<const FeatureObservation> observations);
    void remove_outliers(WindowSummary& summary);

    WindowConfig config_;
    CalibrationConfig calibration_config_;
    RegularityConfig regularity_config_;
    RangeConfig range_config_;
    ImuNoise noise_;
    StageObserver* observer_ = nullptr;
    WindowState state_;
    WindowCameras cameras_;
    WindowProblem problem_;
    Marginalizer marginalizer_;
    LevenbergWorkspace workspace_;
    RedundancyTest redundancy_;
    PlaneSet planes_;
    PlaneProposals proposals_;
    CameraModel left_;
    CalibrationMatrix given_information_;  ///< about the calibration, if it is as good as stated
    CalibrationQuality quality_;
    bool keeps_given_ = true;  ///< what was given is not in the prior
    bool is_resumed_ = false;  ///< an earlier run's calibration waits for the first start
    RigCalibration::Tangent resumed_information_;
    Timestamp wandered_;  ///< up to when the calibration in the prior has wandered
    ResidualBias residual_bias_;
    VisionResiduals residuals_;
    boost::container::static_vector<LandmarkId, kMaxFeatures> rejected_;
    boost::container::static_vector<LandmarkPrediction, kMaxLandmarks> predictions_;
    int current_system_ = 0;      ///< which workspace system holds the last matrix
    bool is_factorized_ = false;  ///< and the solver its factor
    CamerasCovariance cameras_covariance_;
    bool has_cameras_covariance_ = false;  ///< of that factor
    std::uint64_t dropped_landmarks_ = 0;  ///< since configure(), for want of room
    bool marginalization_failed_ = false;
    bool images_rest_ = false;  ///< at the newest keyframe
    int ground_doubt_ = 0;      ///< keyframes for which the range finder stays in doubt
    bool is_guessed_ = false;   ///< the newest keyframe began at a guess
};

}  // namespace facet
