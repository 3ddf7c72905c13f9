// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/marginalization.h"

#include <Eigen/Cholesky>

#include "platform/base/assert.h"

namespace facet {
namespace {

using StateMatrix = Eigen::Matrix<double, kStateDim, kStateDim>;
using StateVector = Eigen::Matrix<double, kStateDim, 1>;

bool seen_by(const Landmark& landmark, int keyframe) {
    return !landmark.observations.empty() && landmark.observations.front().keyframe == keyframe;
}

void bind(Keyframe& keyframe) {
    if (!keyframe.is_bound) {
        keyframe.is_bound = true;
        keyframe.state_lin = keyframe.state;
    }
}

/// Binds the oldest keyframe; if it is free although the prior covers it (the first prior), the prior moves along.
void bind_first(WindowState& state) {
    Keyframe& first = state.keyframes[0];
    if (!first.is_bound && state.prior.keyframes() == 1) {
        state.prior.rebase_single(first.state_lin.box_minus_to(first.state));
    }
    bind(first);
}

/// Drops the observation of keyframe 0 and moves the others one keyframe down.
void shift(Landmark& landmark, const WindowProblem& problem) {
    if (seen_by(landmark, 0)) {
        if (landmark.has_point && landmark.observations.size() >= 2) {
            const ScaledWorldPoint world(problem.left_camera(0), landmark.point);
            const CameraPose& host = problem.left_camera(landmark.observations[1].keyframe);
            landmark.has_point = (host.R_C_W * world.from(host.p_W_C)).z() > 0.0;
            if (landmark.has_point) {
                landmark.point = world.in(host);
            }
        }
        landmark.observations.erase(landmark.observations.begin());
    }
    for (LandmarkObservation& o : landmark.observations) {
        --o.keyframe;
    }
}

}  // namespace

Status marginalize_first_keyframe(const ReducedSystem& system, const Eigen::Ref<const Eigen::VectorXd>& displacement,
                                  PriorFactor& prior) {
    const int rest = system.keyframes() - 1;
    FACET_ASSERT(rest >= 1 && displacement.size() == rest * kStateDim);
    const auto h = system.h();
    const auto g = system.g();
    StateMatrix h_00 = h.topLeftCorner<kStateDim, kStateDim>();
    h_00.triangularView<Eigen::StrictlyUpper>() = h_00.transpose();
    const Eigen::LLT<StateMatrix> llt(h_00);
    if (llt.info() != Eigen::Success) {
        return Status::kDegenerate;
    }
    const StateVector w_0 = llt.solve(g.head<kStateDim>());
    prior.reset(rest);
    auto h_prior = prior.h();
    auto g_prior = prior.g();
    for (int i = 0; i < rest; ++i) {
        const StateMatrix h_i0 = h.block<kStateDim, kStateDim>(kStateDim * (i + 1), 0);
        const StateMatrix w_i = llt.solve(h_i0.transpose()).transpose();  // H_i0 H_00^-1
        for (int j = 0; j <= i; ++j) {
            StateMatrix block = h.block<kStateDim, kStateDim>(kStateDim * (i + 1), kStateDim * (j + 1));
            if (i == j) {
                block.triangularView<Eigen::StrictlyUpper>() = block.transpose();
            }
            block.noalias() -= w_i * h.block<kStateDim, kStateDim>(kStateDim * (j + 1), 0).transpose();
            h_prior.block<kStateDim, kStateDim>(kStateDim * i, kStateDim * j) = block;
            h_prior.block<kStateDim, kStateDim>(kStateDim * j, kStateDim * i) = block.transpose();
        }
        g_prior.segment<kStateDim>(kStateDim * i) = g.segment<kStateDim>(kStateDim * (i + 1)) - h_i0 * w_0;
    }
    g_prior.noalias() -= h_prior * displacement;
    return Status::kOk;
}

Status Marginalizer::marginalize_oldest(WindowState& state, WindowProblem& problem, ReducedSystem& system) {
    const int newest = static_cast<int>(state.keyframes.size()) - 1;
    FACET_ASSERT(newest >= 1);
    bind_first(state);
    bind(state.keyframes[1]);
    for (int i = 0; i < state.landmarks.size(); ++i) {
        const Landmark& landmark = state.landmarks[i];
        const bool ended = !landmark.observations.empty() && landmark.observations.back().keyframe != newest;
        selected_[static_cast<std::size_t>(i)] = seen_by(landmark, 0) && landmark.is_active && ended;
        if (selected_[static_cast<std::size_t>(i)]) {
            for (const LandmarkObservation& o : landmark.observations) {
                bind(state.keyframes[static_cast<std::size_t>(o.keyframe)]);
            }
        }
    }
    problem.linearize_oldest(system, selected_);

    displacement_.setZero(newest * kStateDim);
    for (int k = 1; k <= newest; ++k) {
        const Keyframe& keyframe = state.keyframes[static_cast<std::size_t>(k)];
        if (keyframe.is_bound) {
            displacement_.segment<kStateDim>(kStateDim * (k - 1)) = keyframe.state_lin.box_minus_to(keyframe.state);
        }
    }
    const Status status = marginalize_first_keyframe(system, displacement_, state.prior);
    for (int i = 0; i < state.landmarks.size(); ++i) {
        if (selected_[static_cast<std::size_t>(i)]) {
            state.landmarks[i].observations.clear();
        }
        shift(state.landmarks[i], problem);
    }
    state.landmarks.remove_if([](const Landmark& l) { return l.observations.empty(); });
    state.keyframes.erase(state.keyframes.begin());
    return status;
}

}  // namespace facet
