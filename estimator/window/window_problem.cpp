// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/window_problem.h"

#include <algorithm>

#include "estimator/factors/ground_factor.h"
#include "estimator/factors/rest_factor.h"
#include "estimator/values/stage_scope.h"
#include "estimator/window/plane_gravity.h"
#include "platform/base/assert.h"

namespace facet {
namespace {

// Keeps definite a plane that has just lost its landmarks, and a level of the ground without readings; this information
// is negligible otherwise.
constexpr double kGuard = 1e-4;

}  // namespace

static_assert(PriorFactor::kMaxCalibration == kCalibrationDim, "room for all that keyframes share");

void WindowProblem::bind(WindowState& state, WindowCameras& cameras, const CalibrationConfig& calibration,
                         const RegularityConfig& regularity, const RangeConfig& range) {
    state_ = &state;
    cameras_ = &cameras;
    calibration_config_ = &calibration;
    regularity_config_ = &regularity;
    range_config_ = &range;
}

void WindowProblem::refresh() {
    cameras_->update();
    if (!cameras_->take_lenses()) {
        return;
    }
    for (int i = 0; i < state_->landmarks.size(); ++i) {
        for (LandmarkObservation& o : state_->landmarks[i].observations) {
            cameras_->correct(o);
        }
    }
}

double WindowProblem::linearize(ReducedSystem& system) {
    const StageScope scope(observer_, Stage::kLinearization);
    system.reset(static_cast<int>(state_->keyframes.size()), globals());
    return add_all(system);
}

double WindowProblem::linearize_gradient(ReducedSystem& system) {
    const StageScope scope(observer_, Stage::kLinearization);
    system.reset_gradient(static_cast<int>(state_->keyframes.size()), globals());
    return add_all(system);
}

double WindowProblem::add_all(ReducedSystem& system) {
    refresh();
    double cost = 0.0;
    fit_ = {};
    begin_landmarks(system);
    for (int i = 0; i < state_->landmarks.size(); ++i) {
        if (state_->landmarks[i].is_active) {
            cost += add_landmark(system, state_->landmarks[i], &weights_[static_cast<std::size_t>(i)]);
        }
    }
    end_landmarks(system);
    cost += add_prior(system);
    cost += add_given_calibration(system);
    cost += add_planes(system);
    for (int k = 1; k < system.keyframes(); ++k) {
        cost += add_link(system, k);
    }
    if (state_->has_ground) {
        if (system.has_matrix()) {
            system.h().diagonal().segment(ground_row(), state_->ground_dim()).array() += kGuard;
        }
        for (int k = 0; k < system.keyframes(); ++k) {
            cost += add_ground(system, k);
        }
    }
    return cost;
}

double WindowProblem::linearize_oldest(ReducedSystem& system, const std::array<bool, kMaxLandmarks>& is_selected) {
    system.reset(static_cast<int>(state_->keyframes.size()), globals());
    refresh();
    double cost = 0.0;
    begin_landmarks(system);
    for (int i = 0; i < state_->landmarks.size(); ++i) {
        if (is_selected[static_cast<std::size_t>(i)]) {
            cost += add_landmark(system, state_->landmarks[i], nullptr);
        }
    }
    end_landmarks(system);
    return cost + add_prior(system) + add_link(system, 1) + add_ground(system, 0);
}

double WindowProblem::linearize_inertial(ReducedSystem& system, int keyframe) {
    system.reset(static_cast<int>(state_->keyframes.size()), globals());
    double cost = add_prior(system) + add_ground(system, keyframe);
    for (int k = std::max(1, keyframe); k <= std::min(keyframe + 1, system.keyframes() - 1); ++k) {
        cost += add_link(system, k);
    }
    return cost;
}

double WindowProblem::add_prior(ReducedSystem& system) {
    const PriorFactor& prior = state_->prior;
    prior_displacement_.resize(prior.dim());
    prior_gradient_.resize(prior.dim());
    const int globals = prior.globals();
    FACET_ASSERT(globals == system.globals());
    state_->globals_displacement(plane_row(0), prior_displacement_.head(globals));
    for (int k = 0; k < prior.keyframes(); ++k) {
        const Keyframe& keyframe = state_->keyframes[static_cast<std::size_t>(k)];
        prior_displacement_.segment<kStateDim>(system.offset(k)) = keyframe.state_lin.box_minus_to(keyframe.state);
    }
    const double cost = prior.evaluate(prior_displacement_, prior_gradient_);
    if (prior.keyframes() == 1 && !state_->keyframes[0].is_bound) {
        // The first prior may be far off in attitude: use its exact Jacobian until marginalization binds it.
        Eigen::Matrix<double, kStateDim, kStateDim> jacobian = Eigen::Matrix<double, kStateDim, kStateDim>::Identity();
        jacobian.block<3, 3>(kTheta, kTheta) =
            so3_right_jacobian_inverse(prior_displacement_.segment<3>(globals + kTheta));
        const Eigen::Matrix<double, kStateDim, kStateDim> h = prior.h().bottomRightCorner<kStateDim, kStateDim>();
        if (system.has_matrix()) {
            system.add_state_block(0, 0, jacobian.transpose() * h * jacobian);
            system.h().topLeftCorner(globals, globals) += prior.h().topLeftCorner(globals, globals);
        }
        system.add_state_gradient(0, jacobian.transpose() * prior_gradient_.tail<kStateDim>());
        system.g().head(globals) += prior_gradient_.head(globals);
        return cost;
    }
    if (system.has_matrix()) {
        system.h().topLeftCorner(prior.dim(), prior.dim()) += prior.h();
    }
    system.g().head(prior.dim()) += prior_gradient_;
    return cost;
}

double WindowProblem::add_given_calibration(ReducedSystem& system) const {
    const int dim = static_cast<int>(state_->given.rows());
    const RigCalibration::Tangent all = RigCalibration{}.box_minus_to(state_->calibration);
    const auto correction = all.head(dim);
    if (system.has_matrix()) {
        system.h().topLeftCorner(dim, dim) += state_->given;
    }
    const auto gradient = state_->given.lazyProduct(correction).eval();
    system.g().head(dim) += gradient;
    return 0.5 * correction.dot(gradient);
}

double WindowProblem::add_planes(ReducedSystem& system) const {
    if (state_->planes.empty()) {
        return 0.0;
    }
    const int rows = kPlaneDim * static_cast<int>(state_->planes.size());
    if (system.has_matrix()) {
        system.h().diagonal().segment(plane_row(0), rows).array() += kGuard;
    }
    return add_plane_gravity(state_->planes, plane_row(0), system);
}

double WindowProblem::add_ground(ReducedSystem& system, int keyframe) const {
    const Keyframe& k = state_->keyframes[static_cast<std::size_t>(keyframe)];
    if (k.ground.level == GroundReading::kNone) {
        return 0.0;
    }
    static_assert(kTheta == 0 && kPos == 3, "the pose comes first");
    const GroundHeight height = linearize_ground_height(k.state, k.linearization_point(), k.ground.p_B);
    const double ground_m = state_->ground[static_cast<std::size_t>(k.ground.level)].height_m;
    const double weight = 1.0 / (range_config_->sigma_m * range_config_->sigma_m);
    const double error_m = height.height_m - ground_m;
    const Eigen::Matrix<double, 1, 6>& row = height.d_height_d_pose;
    const int pose = system.offset(keyframe);
    const int level = ground_row() + k.ground.level;
    system.g().segment<6>(pose) += weight * error_m * row.transpose();
    system.g()(level) -= weight * error_m;
    if (system.has_matrix()) {
        system.h().block<6, 6>(pose, pose) += weight * row.transpose() * row;
        system.h().block<6, 1>(pose, level) -= weight * row.transpose();
        system.h()(level, level) += weight;
    }
    return 0.5 * weight * error_m * error_m;
}

double WindowProblem::add_imu(ReducedSystem& system, int keyframe) {
    const Keyframe& i = state_->keyframes[static_cast<std::size_t>(keyframe - 1)];
    const Keyframe& j = state_->keyframes[static_cast<std::size_t>(keyframe)];
    if (!j.has_imu_factor) {
        return 0.0;
    }
    ImuFactorLinearization l;
    j.imu_from_previous.linearize(i.state, j.state, i.linearization_point(), j.linearization_point(), l,
                                  &state_->calibration.imu);
    if (system.has_matrix()) {
        system.add_state_block(keyframe - 1, keyframe - 1, l.d_r_d_i.transpose() * l.d_r_d_i);
        system.add_state_block(keyframe, keyframe - 1, l.d_r_d_j.transpose() * l.d_r_d_i);
        system.add_state_block(keyframe, keyframe, l.d_r_d_j.transpose() * l.d_r_d_j);
    }
    system.add_state_gradient(keyframe - 1, l.d_r_d_i.transpose() * l.r);
    system.add_state_gradient(keyframe, l.d_r_d_j.transpose() * l.r);
    if (calibration_config_->estimate_imu) {
        add_imu_scale(l, keyframe, system);
    }
    return 0.5 * l.r.squaredNorm();
}

void WindowProblem::add_imu_scale(const ImuFactorLinearization& l, int keyframe, ReducedSystem& system) const {
    constexpr int kDim = ImuScale::kDim;
    const auto d_transposed = l.d_r_d_scale.transpose();
    system.g().segment<kDim>(kImuScale) += d_transposed.lazyProduct(l.r);
    if (!system.has_matrix()) {
        return;
    }
    auto h = system.h();
    h.block<kDim, kDim>(kImuScale, kImuScale) += d_transposed.lazyProduct(l.d_r_d_scale);
    h.block<kStateDim, kDim>(system.offset(keyframe - 1), kImuScale) +=
        l.d_r_d_i.transpose().lazyProduct(l.d_r_d_scale);
    h.block<kStateDim, kDim>(system.offset(keyframe), kImuScale) += l.d_r_d_j.transpose().lazyProduct(l.d_r_d_scale);
}

double WindowProblem::add_rest(ReducedSystem& system, int keyframe) {
    const Keyframe& i = state_->keyframes[static_cast<std::size_t>(keyframe - 1)];
    const Keyframe& j = state_->keyframes[static_cast<std::size_t>(keyframe)];
    if (!j.rests_since_previous) {
        return 0.0;
    }
    RestFactorLinearization l;
    linearize_rest(i.state, j.state, i.linearization_point(), j.linearization_point(), RestSigmas{}, l);
    if (system.has_matrix()) {
        system.add_state_block(keyframe - 1, keyframe - 1, l.d_r_d_i.transpose() * l.d_r_d_i);
        system.add_state_block(keyframe, keyframe - 1, l.d_r_d_j.transpose() * l.d_r_d_i);
        system.add_state_block(keyframe, keyframe, l.d_r_d_j.transpose() * l.d_r_d_j);
    }
    system.add_state_gradient(keyframe - 1, l.d_r_d_i.transpose() * l.r);
    system.add_state_gradient(keyframe, l.d_r_d_j.transpose() * l.r);
    return 0.5 * l.r.squaredNorm();
}

Status WindowProblem::solve(ReducedSolver& solver, const ReducedSystem& system, double lambda) {
    const StageScope scope(observer_, Stage::kSolve);
    return solver.solve(system, lambda);
}

Status WindowProblem::solve_again(ReducedSolver& solver, const ReducedSystem& system) {
    const StageScope scope(observer_, Stage::kSolve);
    return solver.solve_again(system);
}

void WindowProblem::save() {
    for (std::size_t k = 0; k < state_->keyframes.size(); ++k) {
        saved_[k] = state_->keyframes[k].state;
    }
    saved_calibration_ = state_->calibration;
    saved_fit_ = fit_;
    saved_ground_ = state_->ground;
    for (int i = 0; i < state_->landmarks.size(); ++i) {
        saved_landmarks_[static_cast<std::size_t>(i)] = state_->landmarks[i];
    }
    std::copy_n(weights_.begin(), state_->landmarks.size(), saved_weights_.begin());
    for (std::size_t p = 0; p < state_->planes.size(); ++p) {
        saved_planes_[p] = state_->planes[p].plane;
    }
}

void WindowProblem::apply(const ReducedSolver::Step& step) {
    RigCalibration::Tangent correction = RigCalibration::Tangent::Zero();
    correction.head(calibration_config_->dim()) = step.head(calibration_config_->dim());
    state_->calibration = saved_calibration_.box_plus(correction);
    for (int l = 0; l < state_->ground_dim(); ++l) {
        const auto at = static_cast<std::size_t>(l);
        state_->ground[at].height_m = saved_ground_[at].height_m + step(ground_row() + l);
    }
    for (std::size_t p = 0; p < state_->planes.size(); ++p) {
        state_->planes[p].plane = saved_planes_[p].box_plus(step.segment<kPlaneDim>(plane_row(static_cast<int>(p))));
    }
    for (std::size_t k = 0; k < state_->keyframes.size(); ++k) {
        state_->keyframes[k].state =
            saved_[k].box_plus(step.segment<kStateDim>(globals() + kStateDim * static_cast<Eigen::Index>(k)));
    }
}

void WindowProblem::restore() {
    for (std::size_t k = 0; k < state_->keyframes.size(); ++k) {
        state_->keyframes[k].state = saved_[k];
    }
    state_->calibration = saved_calibration_;
    state_->ground = saved_ground_;
    fit_ = saved_fit_;
    for (int i = 0; i < state_->landmarks.size(); ++i) {
        static_cast<LandmarkFit&>(state_->landmarks[i]) = saved_landmarks_[static_cast<std::size_t>(i)];
    }
    std::copy_n(saved_weights_.begin(), state_->landmarks.size(), weights_.begin());
    for (std::size_t p = 0; p < state_->planes.size(); ++p) {
        state_->planes[p].plane = saved_planes_[p];
    }
}

}  // namespace facet
