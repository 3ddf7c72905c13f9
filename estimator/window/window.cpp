// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/window.h"

#include <algorithm>
#include <cmath>

#include "estimator/values/stage_scope.h"
#include "estimator/window/ground_levels.h"
#include "estimator/window/local_map.h"
#include "estimator/window/outlier_removal.h"
#include "estimator/window/residual_count.h"
#include "platform/base/assert.h"

namespace facet {
namespace {

// When the window is full, a keyframe that moved less than this from the one before is dropped first (px).
constexpr double kRedundant_px = 5.0;

/// Standard deviations of a window that begins anew on its own oldest keyframe because its prior was lost, order of the
/// state's tangent: tilt and yaw 0.05 rad, place 0.1 m, velocity 0.3 m/s, biases as before a flight.
Eigen::Matrix<double, kStateDim, 1> emergency_sigmas() {
    Eigen::Matrix<double, kStateDim, 1> sigmas;
    sigmas.segment<3>(kTheta).setConstant(0.05);
    sigmas.segment<3>(kPos).setConstant(0.1);
    sigmas.segment<3>(kVel).setConstant(0.3);
    sigmas.segment<3>(kBiasGyro).setConstant(0.02);
    sigmas.segment<3>(kBiasAccel).setConstant(0.1);
    return sigmas;
}

}  // namespace

void Window::configure(const WindowConfig& config, const CalibrationConfig& calibration, const StereoRig& rig,
                       const ImuNoise& noise, const RegularityConfig& regularity, const RangeConfig& range) {
    config_ = config;
    calibration_config_ = calibration;
    regularity_config_ = PublishedWeights::of_regularities(config, regularity);
    range_config_ = range;
    state_.has_ground = range.enabled;
    ground_doubt_ = 0;
    noise_ = noise;
    left_ = rig.left;
    believe_given(rig);
    is_factorized_ = is_resumed_ = false;
    cameras_.bind(state_, config_, calibration_config_, rig);
    problem_.bind(state_, cameras_, calibration_config_, regularity_config_, range_config_);
    planes_.configure(regularity_config_);
    proposals_.clear();
    state_.clear();
    state_.prior.reset(0);
    state_.calibration = {};
    state_.calibration_lin = {};
    residuals_ = {};
    residual_bias_.reset();
    dropped_landmarks_ = 0;
}

void Window::set_stage_observer(StageObserver* observer) {
    observer_ = observer;
    problem_.set_stage_observer(observer);
}

void Window::believe_given(const StereoRig& rig) {
    const CalibrationMatrix covariance = calibration_covariance(calibration_config_, rig);
    const bool inverted = invert_covariance(covariance, given_information_);
    FACET_ASSERT(inverted);  // positive definite by the ranges of the standard deviations
    if (calibration_config_.estimate_cameras) {
        quality_.reset(covariance);
    }
    state_.given = given_information_;
    keeps_given_ = true;
}

void Window::change_rig(const StereoRig& rig, const RigCalibration& calibration) {
    left_ = rig.left;
    believe_given(rig);
    cameras_.bind(state_, config_, calibration_config_, rig);
    problem_.bind(state_, cameras_, calibration_config_, regularity_config_, range_config_);
    planes_.reset();
    proposals_.clear();
    state_.clear();
    state_.prior.reset(0);
    state_.calibration = calibration;
    state_.calibration_lin = calibration;
    residual_bias_.reset();
    is_factorized_ = is_resumed_ = false;
}

void Window::start(const KeyframeInput& input, const NavState& state,
                   const Eigen::Matrix<double, kStateDim, kStateDim>& information, CalibrationStart calibration) {
    const double time_offset_s = state_.calibration.time_offset_s;  // contained in the stamp
    const CalibrationMatrix calibration_information = begin_calibration(calibration);
    state_.clear();
    planes_.reset();
    proposals_.clear();
    rejected_.clear();
    Keyframe keyframe;
    keyframe.stamp = input.stamp;
    keyframe.w_B = input.w_B;
    keyframe.time_offset_s = time_offset_s;
    keyframe.state = state;
    keyframe.state_lin = state;
    state_.keyframes.push_back(keyframe);
    state_.prior.reset(1, problem_.plane_row(0));
    state_.prior.h().bottomRightCorner<kStateDim, kStateDim>() = information;
    fill_calibration_prior(calibration_information);
    wandered_ = input.stamp;
    is_factorized_ = false;
    add_ground(input);
    add_observations(0, input.observations);
}

void Window::fill_calibration_prior(const CalibrationMatrix& information) {
    const int dim = calibration_config_.dim();
    state_.calibration_lin = state_.calibration;
    state_.prior.h().topLeftCorner(dim, dim) = information;
}

void Window::replace_prior() {
    state_.planes.clear();
    planes_.reset();
    for (int i = 0; i < state_.landmarks.size(); ++i) {
        state_.landmarks[i].plane = state_.landmarks[i].proposed_plane = Landmark::kNoPlane;
    }
    int covered = 0;  // keyframes up to the last one that the old prior alone tied to the one before
    for (int k = 0; k < static_cast<int>(state_.keyframes.size()); ++k) {
        Keyframe& keyframe = state_.keyframes[static_cast<std::size_t>(k)];
        keyframe.is_bound = false;
        keyframe.state_lin = keyframe.state;
        covered = keyframe.has_imu_factor ? covered : k + 1;
    }
    state_.prior.reset(covered, problem_.plane_row(0));
    for (GroundLevel& level : state_.ground) {
        level.height_lin_m = level.height_m;
    }
    for (int k = 0; k < covered; ++k) {
        Keyframe& keyframe = state_.keyframes[static_cast<std::size_t>(k)];
        keyframe.is_bound = covered > 1;
        if (!keyframe.has_imu_factor) {
            const int at = state_.prior.globals() + k * kStateDim;
            state_.prior.h().block<kStateDim, kStateDim>(at, at) =
                emergency_sigmas().cwiseAbs2().cwiseInverse().asDiagonal();
        }
    }
    state_.given = scaled_given();
    keeps_given_ = true;
    fill_calibration_prior(CalibrationMatrix::Zero(calibration_config_.dim(), calibration_config_.dim()));
}

Status Window::add_keyframe(const KeyframeInput& input, const Preintegration& preintegration) {
    FACET_ASSERT(!state_.keyframes.empty());
    Keyframe keyframe;
    FACET_TRY(keyframe.imu_from_previous.set(preintegration, noise_));
    keyframe.stamp = input.stamp;
    keyframe.w_B = input.w_B;
    keyframe.time_offset_s = state_.calibration.time_offset_s;
    keyframe.state = input.guess != nullptr ? *input.guess : preintegration.predict(newest().state);
    keyframe.state_lin = keyframe.state;
    keyframe.has_imu_factor = true;
    keyframe.rests_since_previous = input.rests_since_previous;
    images_rest_ = input.images_rest;
    is_guessed_ = input.guess != nullptr;
    learn_calibration_quality();
    make_room();
    let_calibration_wander(input.stamp);
    state_.keyframes.push_back(keyframe);
    add_ground(input);
    add_observations(static_cast<int>(state_.keyframes.size()) - 1, input.observations);
    return Status::kOk;
}

void Window::make_room() {
    constexpr int kRecent = 3;  // newest keyframes that stay in any case: they determine the velocity
    const StageScope scope(observer_, Stage::kMarginalization);
    marginalization_failed_ = false;
    const int count = static_cast<int>(state_.keyframes.size());
    if (count < config_.keyframes) {
        return;
    }
    const int candidate = count - 1 - kRecent;
    const double threshold = kRedundant_px / left_.focal_px();
    const auto note = [this](Status status) { marginalization_failed_ = marginalization_failed_ || !ok(status); };
    if (candidate >= 1 && redundancy_.is_redundant(state_, candidate, threshold)) {
        note(marginalizer_.drop_between(candidate, state_, cameras_, problem_, workspace_.systems[0]));
    } else {
        count_oldest_residuals(state_, cameras_, residuals_);
        note(marginalizer_.marginalize_oldest(state_, cameras_, problem_, workspace_.systems[0]));
    }
    if (state_.prior.keyframes() == 0) {
        replace_prior();
    }
    if (static_cast<int>(state_.keyframes.size()) >= config_.keyframes) {  // dropping was refused
        note(marginalizer_.marginalize_oldest(state_, cameras_, problem_, workspace_.systems[0]));
        if (state_.prior.keyframes() == 0) {
            replace_prior();
        }
    }
}

std::span<const LandmarkPrediction> Window::predict_landmarks(const NavState& state) {
    predictions_.clear();
    const CameraPose camera = cameras_.left_of(state);
    for (int i = 0; i < state_.landmarks.size(); ++i) {
        const Landmark& landmark = state_.landmarks[i];
        LandmarkPrediction prediction;
        prediction.landmark = landmark.id;
        if (landmark.has_point) {
            const ScaledWorldPoint point(cameras_.left(landmark.observations.front().keyframe), landmark.point);
            const Eigen::Vector3d q = camera.R_C_W * point.from(camera.p_W_C);
            Eigen::Vector2d uv;
            if (q.z() > 0.0 && ok(left_.project(q, uv)) && left_.in_image(uv, 0.0)) {
                prediction.in_view = true;
                prediction.left_xy = cameras_.given_left_xy(q.hnormalized());
                prediction.inverse_depth = point.rho / q.z();
            }
        }
        predictions_.push_back(prediction);
    }
    return {predictions_.data(), predictions_.size()};
}

void Window::add_ground(const KeyframeInput& input) {
    ground_doubt_ = std::max(0, ground_doubt_ - 1);
    if (range_config_.enabled && input.ground_B.has_value() && !doubts_ground()) {
        add_ground_reading(range_config_, problem_.ground_row(), *input.ground_B, input.climb_sigma_m_per_s, state_);
    }
}

void Window::add_observations(int keyframe, std::span<const FeatureObservation> observations) {
    const auto fresh = std::count_if(observations.begin(), observations.end(), [this](const FeatureObservation& o) {
        return state_.landmarks.find(o.landmark) == nullptr;
    });
    dropped_landmarks_ += static_cast<std::uint64_t>(state_.landmarks.make_room(static_cast<int>(fresh), keyframe));
    for (const FeatureObservation& o : observations) {
        Landmark* landmark = state_.landmarks.find_or_insert(o.landmark);
        dropped_landmarks_ += landmark == nullptr ? 1U : 0U;
        if (landmark != nullptr && landmark->observations.size() < landmark->observations.capacity()) {
            landmark->observations.push_back(cameras_.observe(keyframe, o));
        }
    }
}

/// As published, landmarks that the mesh sees on a plane have factors of their own.
void Window::choose_factors() {
    if (!config_.published_weights || regularity_config_.mode == RegularityMode::kS) {
        return;
    }
    for (int i = 0; i < state_.landmarks.size(); ++i) {
        state_.landmarks[i].is_projected = false;
    }
    for (const PlaneProposal& proposal : proposals_) {
        for (const LandmarkId id : proposal.landmarks) {
            if (Landmark* const landmark = state_.landmarks.find(id)) {
                landmark->is_projected = true;
            }
        }
    }
}

WindowSummary Window::optimize(double effort) {
    // With few keyframes a start is not complete; at rest all of them see the same, errors included.
    constexpr std::size_t kSettled = 5;
    WindowSummary summary;
    const bool is_settled = state_.keyframes.size() >= kSettled;
    const bool teaches = is_settled && !newest().rests_since_previous && !images_rest_;
    cameras_.set_settled(is_settled);
    if (teaches) {
        cameras_.learn_noise();
    }
    choose_factors();
    problem_.select_landmarks();
    if (regularity_config_.mode == RegularityMode::kSpr) {
        planes_.update(proposals_, state_, cameras_);
    }
    LevenbergOptions options;
    options.trusts_first = is_guessed_;
    options.max_iterations = std::max(1, static_cast<int>(std::lround(effort * config_.max_iterations)));
    summary.solver = levenberg(problem_, options, workspace_, current_system_);
    if (summary.solver.solver_failed) {
        replace_prior();
        summary.prior_replaced = true;
        summary.solver = levenberg(problem_, options, workspace_, current_system_);
    }
    is_factorized_ = summary.solver.is_factorized;
    has_cameras_covariance_ = false;
    current_system_ = summary.solver.matrix;
    const WindowFit& fit = problem_.fit();
    cameras_.measure_noise(fit.vision_squared_error_px2, fit.vision_rows, fit.vision_scale_px(), fit.vision_loss);
    if (teaches) {
        residual_bias_.add(fit.weighted_residual_px, fit.weights);
    }
    const std::size_t count = state_.keyframes.size();
    if (count >= 2 && newest().has_imu_factor) {
        const Keyframe& j = state_.keyframes[count - 1];
        summary.imu_squared_error =
            j.imu_from_previous.residual(state_.keyframes[count - 2].state, j.state, &state_.calibration.imu)
                .squaredNorm();
    }
    summary.marginalization_failed = marginalization_failed_;
    if (regularity_config_.mode == RegularityMode::kSpr) {
        planes_.judge(state_);
    }
    if (range_config_.enabled && drop_uneven_ground(range_config_, problem_.ground_row(), state_)) {
        ground_doubt_ = config_.keyframes;
    }
    remove_outliers(summary);
    summary.fit = problem_.fit();
    return summary;
}

Status Window::newest_covariance(Eigen::Matrix<double, kStateDim, kStateDim>& covariance) {
    if (!is_factorized_) {
        FACET_TRY(workspace_.solver.solve(workspace_.systems[current_system_], 0.0));
        is_factorized_ = true;
        has_cameras_covariance_ = false;
    }
    covariance = workspace_.solver.last_keyframe_covariance();
    return Status::kOk;
}

Status Window::newest_innovation(InertialInnovation& innovation) const {
    const int last = static_cast<int>(state_.keyframes.size()) - 1;
    if (last < 1 || !newest().has_imu_factor) {
        return Status::kNotFound;
    }
    if (!is_factorized_) {
        return Status::kDegenerate;
    }
    const Keyframe& i = state_.keyframes[static_cast<std::size_t>(last) - 1];
    const Keyframe& j = newest();
    ImuFactorLinearization l;
    j.imu_from_previous.linearize(i.state, j.state, i.linearization_point(), j.linearization_point(), l,
                                  &state_.calibration.imu);
    Eigen::Matrix<double, 9, 2 * kStateDim> a;
    a << l.d_r_d_i.topRows<9>(), l.d_r_d_j.topRows<9>();
    innovation.dt_s = j.imu_from_previous.preintegration().dt_s();
    innovation.r = l.r.head<9>();
    innovation.covariance.setIdentity();
    innovation.covariance -= a * workspace_.solver.last_pair_covariance() * a.transpose();
    return Status::kOk;
}

Status Window::fill_map(LocalMap& map) const {
    if (!is_factorized_) {
        map.clear();
        return Status::kDegenerate;
    }
    return map.build(state_, cameras_, workspace_.systems[current_system_]);
}

double Window::calibration_sigma(int parameter) {
    return parameter < calibration_config_.dim() ? std::sqrt(workspace_.solver.variance(parameter)) : 0.0;
}

double Window::calibration_stretch() const {
    const RigCalibration::Tangent correction = RigCalibration{}.box_minus_to(state_.calibration);
    double stretch = 0.0;
    for (int i = 0; i < calibration_config_.dim(); ++i) {
        stretch = std::max(stretch, std::abs(correction(i)) / calibration_config_.sigma(i));
    }
    return stretch;
}

void Window::report(const WindowSummary& summary, Health& health) const {
    health.keyframes = static_cast<int>(state_.keyframes.size());
    health.landmarks = summary.fit.active_landmarks;
    health.landmarks_dropped = dropped_landmarks_;
    health.pixel_sigma_px = cameras_.noise().sigma_px();
    health.imu_chi2 = summary.imu_squared_error / kStateDim;
    health.time_offset_s = state_.calibration.time_offset_s;
    health.calibration_stretch = calibration_stretch();
    health.calibration_scale = calibration_scale();
    health.residual_bias_px = residual_bias_px();
}

void Window::remove_outliers(WindowSummary& summary) {
    const StageScope scope(observer_, Stage::kTriangulation);
    problem_.refresh();
    rejected_.clear();
    const OutlierCount count = facet::remove_outliers(WindowConfig::kOutlierThreshold_px, state_, cameras_, rejected_);
    summary.rejected_observations = count.observations;
    summary.rejected_landmarks = static_cast<int>(rejected_.size());
    const int newest = static_cast<int>(state_.keyframes.size()) - 1;
    for (int i = 0; i < state_.landmarks.size(); ++i) {
        const Landmark& landmark = state_.landmarks[i];
        summary.newest_landmarks += landmark.is_active && landmark.observations.back().keyframe == newest ? 1 : 0;
    }
}

Status Window::replace_imu_factor(int keyframe, const Preintegration& preintegration) {
    FACET_ASSERT(keyframe >= 1 && keyframe < static_cast<int>(state_.keyframes.size()));
    return state_.keyframes[static_cast<std::size_t>(keyframe)].imu_from_previous.set(preintegration, noise_);
}

}  // namespace facet
