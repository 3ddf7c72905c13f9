// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/window_problem.h"

#include "estimator/geometry/triangulation.h"
#include "estimator/window/stage_scope.h"

namespace facet {
namespace {

/// Standard deviation of the prior on inverse depth (1/m): weak against any real baseline, holds points without one.
constexpr double kRhoPriorSigma = 3.0;

}  // namespace

void WindowProblem::bind(WindowState& state, const WindowConfig& config, const StereoRig& rig) {
    state_ = &state;
    config_ = &config;
    T_B_C0_ = rig.T_B_C0;
    T_B_C1_ = rig.T_B_C1;
    geometry_.R_C0_B = rig.T_B_C0.R().transpose();
    geometry_.R_C1_B = rig.T_B_C1.R().transpose();
    geometry_.p_B_C0 = rig.T_B_C0.p;
    geometry_.p_B_C1 = rig.T_B_C1.p;
    geometry_.scale_left = rig.left.focal_px() / config.pixel_sigma_px;
    geometry_.scale_right = rig.right.focal_px() / config.pixel_sigma_px;
}

void WindowProblem::update_cameras() {
    for (std::size_t k = 0; k < state_->keyframes.size(); ++k) {
        const Se3 T_W_B = state_->keyframes[k].state.T_W_B();
        left_[k] = CameraPose::from(T_W_B * T_B_C0_);
        right_[k] = CameraPose::from(T_W_B * T_B_C1_);
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
        landmark.is_active = landmark.observations.size() >= 2 && triangulate_landmark(landmark);
        landmark.cost = 0.0;
    }
}

double WindowProblem::linearize(ReducedSystem& system) {
    const StageScope scope(observer_, Stage::kLinearization);
    const int keyframes = static_cast<int>(state_->keyframes.size());
    system.reset(keyframes);
    update_cameras();
    double cost = add_prior(system);
    for (int k = 1; k < keyframes; ++k) {
        cost += add_imu(system, k);
    }
    fit_ = {};
    for (int i = 0; i < state_->landmarks.size(); ++i) {
        if (state_->landmarks[i].is_active) {
            cost += add_landmark(system, state_->landmarks[i]);
        }
    }
    return cost;
}

double WindowProblem::linearize_oldest(ReducedSystem& system, const std::array<bool, kMaxLandmarks>& is_selected) {
    system.reset(static_cast<int>(state_->keyframes.size()));
    update_cameras();
    double cost = add_prior(system) + add_imu(system, 1);
    for (int i = 0; i < state_->landmarks.size(); ++i) {
        if (is_selected[static_cast<std::size_t>(i)]) {
            cost += add_landmark(system, state_->landmarks[i]);
        }
    }
    return cost;
}

double WindowProblem::add_prior(ReducedSystem& system) {
    const PriorFactor& prior = state_->prior;
    prior_displacement_.resize(prior.dim());
    prior_gradient_.resize(prior.dim());
    for (int k = 0; k < prior.keyframes(); ++k) {
        const Keyframe& keyframe = state_->keyframes[static_cast<std::size_t>(k)];
        prior_displacement_.segment<kStateDim>(kStateDim * k) = keyframe.state_lin.box_minus_to(keyframe.state);
    }
    const double cost = prior.evaluate(prior_displacement_, prior_gradient_);
    if (prior.keyframes() == 1 && !state_->keyframes[0].is_bound) {
        // The first prior may be far off in attitude: its exact Jacobian, until marginalization binds it.
        Eigen::Matrix<double, kStateDim, kStateDim> jacobian = Eigen::Matrix<double, kStateDim, kStateDim>::Identity();
        jacobian.block<3, 3>(kTheta, kTheta) = so3_right_jacobian_inverse(prior_displacement_.segment<3>(kTheta));
        const Eigen::Matrix<double, kStateDim, kStateDim> h = prior.h();
        system.h().topLeftCorner<kStateDim, kStateDim>() += jacobian.transpose() * h * jacobian;
        system.g().head<kStateDim>() += jacobian.transpose() * prior_gradient_.head<kStateDim>();
        return cost;
    }
    system.h().topLeftCorner(prior.dim(), prior.dim()) += prior.h();
    system.g().head(prior.dim()) += prior_gradient_;
    return cost;
}

double WindowProblem::add_imu(ReducedSystem& system, int keyframe) {
    const Keyframe& i = state_->keyframes[static_cast<std::size_t>(keyframe - 1)];
    const Keyframe& j = state_->keyframes[static_cast<std::size_t>(keyframe)];
    ImuFactorLinearization l;
    j.imu_from_previous.linearize(i.state, j.state, i.linearization_point(), j.linearization_point(), l);
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
        const Keyframe& keyframe = state_->keyframes[static_cast<std::size_t>(o.keyframe)];
        StereoLinearization l;
        if (!ok(linearize_stereo(o.measurement, geometry_, keyframe.state.T_W_B(),
                                 keyframe.linearization_point().T_W_B(), host, landmark.point, loss, l))) {
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
}

void WindowProblem::apply(const ReducedSolver::Step& step) {
    for (std::size_t k = 0; k < state_->keyframes.size(); ++k) {
        state_->keyframes[k].state =
            saved_[k].box_plus(step.segment<kStateDim>(kStateDim * static_cast<Eigen::Index>(k)));
    }
}

void WindowProblem::restore() {
    for (std::size_t k = 0; k < state_->keyframes.size(); ++k) {
        state_->keyframes[k].state = saved_[k];
    }
}

}  // namespace facet
