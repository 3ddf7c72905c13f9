// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/marginalization.h"

#include <Eigen/Cholesky>

#include "platform/base/assert.h"

namespace facet {
namespace {

using StateMatrix = Eigen::Matrix<double, kStateDim, kStateDim>;
/// Coupling of all remaining parameters to the leaving keyframe.
using Coupling = Eigen::Matrix<double, Eigen::Dynamic, kStateDim, 0, kMaxSystemDim, kStateDim>;

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

/// Drops the observation by a keyframe and moves those of later keyframes down by one.
void drop_observation(Landmark& landmark, int keyframe, const WindowCameras& cameras) {
    if (seen_by(landmark, keyframe)) {  // the landmark loses the host of its chart
        if (landmark.has_point && landmark.observations.size() >= 2) {
            const ScaledWorldPoint world(cameras.left(keyframe), landmark.point);
            const CameraPose& host = cameras.left(landmark.observations[1].keyframe);
            landmark.has_point = (host.R_C_W * world.from(host.p_W_C)).z() > 0.0;
            if (landmark.has_point) {
                landmark.point = world.in(host);
            }
        }
    }
    auto& observations = landmark.observations;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < observations.size(); ++i) {
        LandmarkObservation o = observations[i];
        if (o.keyframe == keyframe) {
            continue;
        }
        o.keyframe -= o.keyframe > keyframe ? 1 : 0;
        observations[kept++] = o;
    }
    observations.resize(kept);
}

}  // namespace

Status marginalize_keyframe(const ReducedSystem& system, int keyframe,
                            const Eigen::Ref<const Eigen::VectorXd>& displacement, PriorFactor& prior) {
    const int rest = system.keyframes() - 1;
    FACET_ASSERT(rest >= 1 && keyframe >= 0 && keyframe <= rest);
    FACET_ASSERT(displacement.size() == system.dim() - kStateDim);
    const auto h = system.h();
    const auto g = system.g();
    const int m = system.offset(keyframe);
    StateMatrix h_mm = h.block<kStateDim, kStateDim>(m, m);
    h_mm.triangularView<Eigen::StrictlyUpper>() = h_mm.transpose();
    const Eigen::LLT<StateMatrix> llt(h_mm);
    if (llt.info() != Eigen::Success) {
        return Status::kDegenerate;
    }
    // The remaining rows: `before` above the keyframe's, `after` below.
    const int before = m;
    const int after = system.dim() - m - kStateDim;
    Coupling w(before + after, kStateDim);  // H_rm L^-T, so that H_rm H_mm^-1 H_mr = W W^T
    w.topRows(before) = h.block(m, 0, kStateDim, before).transpose();
    w.bottomRows(after) = h.block(m + kStateDim, m, after, kStateDim);
    llt.matrixU().solveInPlace<Eigen::OnTheRight>(w);

    prior.reset(rest, system.globals());
    auto h_prior = prior.h();
    auto g_prior = prior.g();
    h_prior.topLeftCorner(before, before) = h.topLeftCorner(before, before);
    h_prior.bottomLeftCorner(after, before) = h.bottomLeftCorner(after, before);
    h_prior.bottomRightCorner(after, after) = h.bottomRightCorner(after, after);
    h_prior.selfadjointView<Eigen::Lower>().rankUpdate(w, -1.0);
    h_prior.triangularView<Eigen::StrictlyUpper>() = h_prior.transpose();
    g_prior.head(before) = g.head(before);
    g_prior.tail(after) = g.tail(after);
    g_prior.noalias() -= w * llt.matrixL().solve(g.segment<kStateDim>(m));
    g_prior.noalias() -= h_prior * displacement;
    return Status::kOk;
}

void Marginalizer::fill_displacement(const WindowState& state, int leaving, int globals) {
    const int keyframes = static_cast<int>(state.keyframes.size());
    displacement_.setZero(globals + (keyframes - 1) * kStateDim);
    state.globals_displacement(globals - kPlaneDim * static_cast<int>(state.planes.size()),
                               displacement_.head(globals));
    int row = globals;
    for (int k = 0; k < keyframes; ++k) {
        const Keyframe& keyframe = state.keyframes[static_cast<std::size_t>(k)];
        if (k == leaving) {
            continue;
        }
        if (keyframe.is_bound) {
            displacement_.segment<kStateDim>(row) = keyframe.state_lin.box_minus_to(keyframe.state);
        }
        row += kStateDim;
    }
}

Status Marginalizer::marginalize_oldest(WindowState& state, const WindowCameras& cameras, WindowProblem& problem,
                                        ReducedSystem& system) {
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
            if (landmark.plane != Landmark::kNoPlane) {
                state.planes[static_cast<std::size_t>(landmark.plane)].bind();
            }
        }
    }
    problem.linearize_oldest(system, selected_);

    fill_displacement(state, 0, system.globals());
    const Status status = marginalize_keyframe(system, 0, displacement_, state.prior);
    if (!ok(status)) {
        state.prior.reset(0);  // it knows a keyframe that the window no longer has
    }
    for (int i = 0; i < state.landmarks.size(); ++i) {
        if (selected_[static_cast<std::size_t>(i)]) {
            state.landmarks[i].observations.clear();
        }
        drop_observation(state.landmarks[i], 0, cameras);
    }
    state.landmarks.remove_if([](const Landmark& l) { return l.observations.empty(); });
    state.keyframes.erase(state.keyframes.begin());
    state.keyframes.front().has_imu_factor = false;
    state.keyframes.front().rests_since_previous = false;
    return status;
}

Status Marginalizer::drop_between(int keyframe, WindowState& state, const WindowCameras& cameras,
                                  WindowProblem& problem, ReducedSystem& system) {
    FACET_ASSERT(keyframe >= 1 && keyframe + 1 < static_cast<int>(state.keyframes.size()));
    const auto k = static_cast<std::size_t>(keyframe);
    bind_first(state);
    bind(state.keyframes[k - 1]);
    bind(state.keyframes[k]);
    bind(state.keyframes[k + 1]);
    problem.linearize_inertial(system, keyframe);
    fill_displacement(state, keyframe, system.globals());
    FACET_TRY(marginalize_keyframe(system, keyframe, displacement_, state.prior));
    for (int i = 0; i < state.landmarks.size(); ++i) {
        drop_observation(state.landmarks[i], keyframe, cameras);
    }
    state.landmarks.remove_if([](const Landmark& l) { return l.observations.empty(); });
    state.keyframes[k + 1].has_imu_factor = false;
    state.keyframes[k + 1].rests_since_previous = false;
    state.keyframes.erase(state.keyframes.begin() + keyframe);
    return Status::kOk;
}

}  // namespace facet
