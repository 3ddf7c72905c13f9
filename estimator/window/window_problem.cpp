// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/window_problem.h"

#include <algorithm>

#include "estimator/factors/rest_factor.h"
#include "estimator/geometry/triangulation.h"
#include "estimator/window/stage_scope.h"
#include "platform/base/assert.h"

namespace facet {
namespace {

/// Standard deviation of the prior on inverse depth (1/m): weak against any real baseline, holds points without one.
constexpr double kRhoPriorSigma = 3.0;

}  // namespace

void WindowProblem::bind(WindowState& state, const WindowConfig& config, const CalibrationConfig& calibration,
                         const StereoRig& rig) {
    state_ = &state;
    config_ = &config;
    calibration_config_ = &calibration;
    T_B_C0_ = rig.T_B_C0;
    T_B_C1_ = rig.T_B_C1;
    geometry_.scale_left = rig.left.focal_px() / config.pixel_sigma_px;
    geometry_.scale_right = rig.right.focal_px() / config.pixel_sigma_px;
}

Se3 WindowProblem::T_W_B_at_image(const Keyframe& keyframe, const NavState& state) const {
    const double late_s = state_->calibration.time_offset_s - keyframe.time_offset_s;
    return {(state.q_W_B * so3_exp(late_s * keyframe.w_B)).normalized(), state.p_W_B + late_s * state.v_W_B};
}

void WindowProblem::update_cameras() {
    const Se3 T_B_C0 = state_->calibration.T_B_Bc * T_B_C0_;
    const Se3 T_B_C1 = state_->calibration.T_B_Bc * T_B_C1_;
    geometry_.R_C0_B = T_B_C0.R().transpose();
    geometry_.R_C1_B = T_B_C1.R().transpose();
    geometry_.p_B_C0 = T_B_C0.p;
    geometry_.p_B_C1 = T_B_C1.p;
    for (std::size_t k = 0; k < state_->keyframes.size(); ++k) {
        const Keyframe& keyframe = state_->keyframes[k];
        body_[k] = T_W_B_at_image(keyframe, keyframe.state);
        body_lin_[k] = T_W_B_at_image(keyframe, keyframe.linearization_point());
        left_[k] = CameraPose::from(body_[k] * T_B_C0);
        right_[k] = CameraPose::from(body_[k] * T_B_C1);
    }
}

bool WindowProblem::triangulate_landmark(Landmark& landmark) const {
    boost::container::static_vector<Sighting, 2 * kMaxKeyframes> sightings;
    for (const LandmarkObservation& o : landmark.observations) {
        const auto k = static_cast<std::size_t>(o.keyframe);
        sightings.push_back({&left_[k], o.measurement.left_xy, geometry_.scale_left});
        if (o.measurement.has_right) {
            sightings.push_back({&right_[k], o.measurement.right_xy, geometry_.scale_right});
        }
    }
    const std::span<const Sighting> span(sightings.data(), sightings.size());
    TriangulationOptions options;
    options.huber_threshold = config_->huber_threshold;
    options.rho_prior_sigma = kRhoPriorSigma;
    options.max_iterations = landmark.has_point ? 3 : 8;
    if (landmark.has_point && ok(triangulate(span, options, landmark.point))) {
        return true;
    }
    options.max_iterations = 8;
    InverseDepthPoint point;
    if (!ok(triangulate_linear(span, point)) || !ok(triangulate(span, options, point))) {
        return false;
    }
    landmark.point = point;
    landmark.has_point = true;
    return true;
}

void WindowProblem::select_landmarks() {
    const StageScope scope(observer_, Stage::kTriangulation);
    update_cameras();
    for (int i = 0; i < state_->landmarks.size(); ++i) {
        Landmark& landmark = state_->landmarks[i];
        // Seen by one keyframe only, a stereo match still tells where to look for the landmark.
        const bool is_known = (landmark.observations.size() >= 2 || landmark.observations[0].measurement.has_right) &&
                              triangulate_landmark(landmark);
        landmark.is_active = is_known && landmark.observations.size() >= 2;
        landmark.cost = 0.0;
    }
}

double WindowProblem::linearize(ReducedSystem& system) {
    const StageScope scope(observer_, Stage::kLinearization);
    const int keyframes = static_cast<int>(state_->keyframes.size());
    system.reset(keyframes, calibration_config_->dim());
    update_cameras();
    double cost = 0.0;
    fit_ = {};
    for (int i = 0; i < state_->landmarks.size(); ++i) {
        if (state_->landmarks[i].is_active) {
            cost += add_landmark(system, state_->landmarks[i]);
        }
    }
    add_calibration(system);
    cost += add_prior(system);
    for (int k = 1; k < keyframes; ++k) {
        cost += add_link(system, k);
    }
    return cost;
}

double WindowProblem::linearize_oldest(ReducedSystem& system, const std::array<bool, kMaxLandmarks>& is_selected) {
    system.reset(static_cast<int>(state_->keyframes.size()), calibration_config_->dim());
    update_cameras();
    double cost = 0.0;
    for (int i = 0; i < state_->landmarks.size(); ++i) {
        if (is_selected[static_cast<std::size_t>(i)]) {
            cost += add_landmark(system, state_->landmarks[i]);
        }
    }
    add_calibration(system);
    return cost + add_prior(system) + add_link(system, 1);
}

double WindowProblem::linearize_inertial(ReducedSystem& system, int keyframe) {
    system.reset(static_cast<int>(state_->keyframes.size()), calibration_config_->dim());
    double cost = add_prior(system);
    for (int k = std::max(1, keyframe); k <= std::min(keyframe + 1, system.keyframes() - 1); ++k) {
        cost += add_link(system, k);
    }
    return cost;
}

void WindowProblem::add_calibration(ReducedSystem& system) const {
    const int dim = system.globals();
    if (dim == 0) {
        return;
    }
    using Columns = Eigen::Matrix<double, kPoseDim, Eigen::Dynamic, 0, kPoseDim, kCalibrationDim>;
    boost::container::static_vector<Columns, kMaxKeyframes> d_pose;
    for (const Keyframe& keyframe : state_->keyframes) {
        const NavState& at = keyframe.linearization_point();
        d_pose.push_back(state_->calibration.d_pose(at.q_W_B.toRotationMatrix(), at.v_W_B, keyframe.w_B).leftCols(dim));
    }
    auto h = system.h();
    auto g = system.g();
    for (int j = 0; j < system.keyframes(); ++j) {
        Columns column = Columns::Zero(kPoseDim, dim);
        for (int k = 0; k < system.keyframes(); ++k) {
            const Columns& d = d_pose[static_cast<std::size_t>(k)];
            if (j >= k) {
                column.noalias() += h.block<kPoseDim, kPoseDim>(system.offset(j), system.offset(k)).lazyProduct(d);
            } else {
                column.noalias() +=
                    h.block<kPoseDim, kPoseDim>(system.offset(k), system.offset(j)).transpose().lazyProduct(d);
            }
        }
        const Columns& d = d_pose[static_cast<std::size_t>(j)];
        h.block(system.offset(j), 0, kPoseDim, dim) += column;
        h.topLeftCorner(dim, dim) += d.transpose().lazyProduct(column);
        g.head(dim) += d.transpose().lazyProduct(g.segment<kPoseDim>(system.offset(j)));
    }
}

double WindowProblem::add_prior(ReducedSystem& system) {
    const PriorFactor& prior = state_->prior;
    prior_displacement_.resize(prior.dim());
    prior_gradient_.resize(prior.dim());
    const int globals = prior.globals();
    FACET_ASSERT(globals == system.globals());
    prior_displacement_.head(globals) = state_->calibration_lin.box_minus_to(state_->calibration).head(globals);
    for (int k = 0; k < prior.keyframes(); ++k) {
        const Keyframe& keyframe = state_->keyframes[static_cast<std::size_t>(k)];
        prior_displacement_.segment<kStateDim>(system.offset(k)) = keyframe.state_lin.box_minus_to(keyframe.state);
    }
    const double cost = prior.evaluate(prior_displacement_, prior_gradient_);
    if (prior.keyframes() == 1 && !state_->keyframes[0].is_bound) {
        // The first prior may be far off in attitude: its exact Jacobian, until marginalization binds it.
        Eigen::Matrix<double, kStateDim, kStateDim> jacobian = Eigen::Matrix<double, kStateDim, kStateDim>::Identity();
        jacobian.block<3, 3>(kTheta, kTheta) =
            so3_right_jacobian_inverse(prior_displacement_.segment<3>(globals + kTheta));
        const Eigen::Matrix<double, kStateDim, kStateDim> h = prior.h().bottomRightCorner<kStateDim, kStateDim>();
        system.add_state_block(0, 0, jacobian.transpose() * h * jacobian);
        system.add_state_gradient(0, jacobian.transpose() * prior_gradient_.tail<kStateDim>());
        system.h().topLeftCorner(globals, globals) += prior.h().topLeftCorner(globals, globals);
        system.g().head(globals) += prior_gradient_.head(globals);
        return cost;
    }
    system.h().topLeftCorner(prior.dim(), prior.dim()) += prior.h();
    system.g().head(prior.dim()) += prior_gradient_;
    return cost;
}

double WindowProblem::add_imu(ReducedSystem& system, int keyframe) {
    const Keyframe& i = state_->keyframes[static_cast<std::size_t>(keyframe - 1)];
    const Keyframe& j = state_->keyframes[static_cast<std::size_t>(keyframe)];
    if (!j.has_imu_factor) {
        return 0.0;
    }
    ImuFactorLinearization l;
    j.imu_from_previous.linearize(i.state, j.state, i.linearization_point(), j.linearization_point(), l);
    system.add_state_block(keyframe - 1, keyframe - 1, l.d_r_d_i.transpose() * l.d_r_d_i);
    system.add_state_block(keyframe, keyframe - 1, l.d_r_d_j.transpose() * l.d_r_d_i);
    system.add_state_block(keyframe, keyframe, l.d_r_d_j.transpose() * l.d_r_d_j);
    system.add_state_gradient(keyframe - 1, l.d_r_d_i.transpose() * l.r);
    system.add_state_gradient(keyframe, l.d_r_d_j.transpose() * l.r);
    return 0.5 * l.r.squaredNorm();
}

double WindowProblem::add_rest(ReducedSystem& system, int keyframe) {
    const Keyframe& i = state_->keyframes[static_cast<std::size_t>(keyframe - 1)];
    const Keyframe& j = state_->keyframes[static_cast<std::size_t>(keyframe)];
    if (!j.rests_since_previous) {
        return 0.0;
    }
    RestFactorLinearization l;
    linearize_rest(i.state, j.state, i.linearization_point(), j.linearization_point(), RestSigmas{}, l);
    system.add_state_block(keyframe - 1, keyframe - 1, l.d_r_d_i.transpose() * l.d_r_d_i);
    system.add_state_block(keyframe, keyframe - 1, l.d_r_d_j.transpose() * l.d_r_d_i);
    system.add_state_block(keyframe, keyframe, l.d_r_d_j.transpose() * l.d_r_d_j);
    system.add_state_gradient(keyframe - 1, l.d_r_d_i.transpose() * l.r);
    system.add_state_gradient(keyframe, l.d_r_d_j.transpose() * l.r);
    return 0.5 * l.r.squaredNorm();
}

double WindowProblem::add_landmark(ReducedSystem& system, Landmark& landmark) {
    if (!triangulate_landmark(landmark)) {
        return landmark.cost;  // out of this step, but leaving must not look like a gain
    }
    const CameraPose& host = left_[static_cast<std::size_t>(landmark.observations.front().keyframe)];
    const HuberLoss loss{config_->huber_threshold};
    schur_.clear();
    double cost = 0.0;
    double squared_error = 0.0;
    int rows = -3;
    for (const LandmarkObservation& o : landmark.observations) {
        const auto k = static_cast<std::size_t>(o.keyframe);
        StereoLinearization l;
        if (!ok(linearize_stereo(o.measurement, geometry_, body_[k], body_lin_[k], host, landmark.point, loss, l))) {
            return landmark.cost;
        }
        schur_.add(o.keyframe, l);
        cost += l.cost;
        squared_error += l.squared_error;
        rows += o.measurement.has_right ? 4 : 2;
    }
    schur_.add_rho_prior(landmark.point.rho, kRhoPriorSigma);
    if (!ok(schur_.eliminate_into(system))) {
        return landmark.cost;
    }
    landmark.cost = cost;
    landmark.squared_error = squared_error;
    ++fit_.active_landmarks;
    fit_.vision_rows += rows;
    fit_.vision_squared_error += squared_error;
    return cost;
}

Status WindowProblem::solve(ReducedSolver& solver, const ReducedSystem& system, double lambda) {
    const StageScope scope(observer_, Stage::kSolve);
    return solver.solve(system, lambda);
}

void WindowProblem::save() {
    for (std::size_t k = 0; k < state_->keyframes.size(); ++k) {
        saved_[k] = state_->keyframes[k].state;
    }
    saved_calibration_ = state_->calibration;
}

void WindowProblem::apply(const ReducedSolver::Step& step) {
    const int globals = calibration_config_->dim();
    RigCalibration::Tangent correction = RigCalibration::Tangent::Zero();
    correction.head(globals) = step.head(globals);
    state_->calibration = saved_calibration_.box_plus(correction);
    for (std::size_t k = 0; k < state_->keyframes.size(); ++k) {
        state_->keyframes[k].state =
            saved_[k].box_plus(step.segment<kStateDim>(globals + kStateDim * static_cast<Eigen::Index>(k)));
    }
}

void WindowProblem::restore() {
    for (std::size_t k = 0; k < state_->keyframes.size(); ++k) {
        state_->keyframes[k].state = saved_[k];
    }
    state_->calibration = saved_calibration_;
}

}  // namespace facet
