// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/plane_set.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>

#include "estimator/window/plane_gravity.h"
#include "estimator/window/point_fit.h"

namespace facet {
namespace {

constexpr double kMinRho = 0.02;     // 1/m: farther landmarks say nothing about a plane
constexpr int kMisfitKeyframes = 2;  // in a row, after which a plane is given up
constexpr int kFirstWait = 8;        // keyframes until a plane that was given up may return
constexpr int kLongestWait = 1024;
constexpr int kMaxLandmarkMisfits = 2;
constexpr double kLeastFitting = 0.6;  // of a proposed plane's landmarks: if fewer fit, clutter was taken for a plane
constexpr double kMaxSigma = 0.15;     // m: a landmark whose height is less certain than this fits everywhere

const PlaneProposal* find(const PlaneProposals& proposals, PlaneId id) {
    const auto at = std::lower_bound(proposals.begin(), proposals.end(), id,
                                     [](const PlaneProposal& p, PlaneId wanted) { return p.id < wanted; });
    return at != proposals.end() && at->id == id ? &*at : nullptr;
}

Eigen::Vector3d position(const Landmark& landmark, const WindowCameras& cameras) {
    return ScaledWorldPoint(cameras.left(landmark.observations.front().keyframe), landmark.point).p_W();
}

bool can_lie_on_planes(const Landmark& landmark) {
    return landmark.is_active && landmark.has_point && landmark.point.rho > kMinRho &&
           landmark.plane_misfits < kMaxLandmarkMisfits;
}

/// Rms extent of points along the narrower direction of the plane through them.
double narrow_extent(const Eigen::Matrix3d& scatter, int count) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter / count, Eigen::EigenvaluesOnly);
    return std::sqrt(std::max(0.0, eigen.eigenvalues()(1)));
}

}  // namespace

void PlaneSet::configure(const RegularityConfig& config) {
    config_ = config;
    reset();
}

void PlaneSet::reset() { refused_.clear(); }

bool PlaneSet::is_refused(PlaneId id) const {
    return std::any_of(refused_.begin(), refused_.end(), [=](const Refusal& r) { return r.id == id && r.left > 0; });
}

void PlaneSet::refuse(PlaneId id) {
    Refusal refusal{id, kFirstWait, kFirstWait};
    const auto known = std::find_if(refused_.begin(), refused_.end(), [=](const Refusal& r) { return r.id == id; });
    if (known != refused_.end()) {
        refusal.wait = refusal.left = std::min(2 * known->wait, kLongestWait);
        refused_.erase(known);
    } else if (refused_.size() == refused_.capacity()) {
        refused_.erase(refused_.begin());  // the one that has not been refused for longest
    }
    refused_.push_back(refusal);
}

bool PlaneSet::measure(const Landmark& landmark, const Plane& plane, const WindowCameras& cameras, Height& out) const {
    PointFit fit;
    const Eigen::Vector3d p_W = position(landmark, cameras);
    if (!fit.add_all(landmark, cameras, p_W)) {
        return false;
    }
    const Eigen::LLT<Eigen::Matrix3d> llt(fit.information);
    if (llt.info() != Eigen::Success) {
        return false;
    }
    out.m = plane.height(p_W);
    out.variance_m2 = cameras.observation_variance() * llt.matrixL().solve(plane.normal_W()).squaredNorm();
    return true;
}

PlaneSet::Fit PlaneSet::judge_fit(const Landmark& landmark, const Plane& plane, const WindowCameras& cameras) const {
    Height height;
    if (!can_lie_on_planes(landmark) || !measure(landmark, plane, cameras, height) ||
        height.variance_m2 > kMaxSigma * kMaxSigma) {
        return Fit::kUnknown;
    }
    const double variance_m2 = height.variance_m2 + config_.sigma_m * config_.sigma_m;
    return height.m * height.m < RegularityConfig::kJoinSigmas * RegularityConfig::kJoinSigmas * variance_m2
               ? Fit::kOn
               : Fit::kOff;
}

/// Whether a plane that comes back is not where it was: what is seen of it now is off it.
bool PlaneSet::has_moved(const PlaneProposal& proposal, const Plane& plane, WindowState& state,
                         const WindowCameras& cameras) const {
    int on = 0;
    int off = 0;
    for (const LandmarkId id : proposal.landmarks) {
        if (const Landmark* landmark = state.landmarks.find(id)) {
            const Fit fit = judge_fit(*landmark, plane, cameras);
            on += fit == Fit::kOn ? 1 : 0;
            off += fit == Fit::kOff ? 1 : 0;
        }
    }
    return off >= RegularityConfig::kKeepConstraints && on < kLeastFitting * (on + off);
}

void PlaneSet::remove(int plane, WindowState& state) const {
    const int calibration = state.prior.globals() - kPlaneDim * static_cast<int>(state.planes.size());
    state.prior.marginalize_plane(calibration + kPlaneDim * plane);
    state.planes.erase(state.planes.begin() + plane);
    for (int i = 0; i < state.landmarks.size(); ++i) {
        int& index = state.landmarks[i].plane;
        index = index == plane ? Landmark::kNoPlane : index - (index > plane ? 1 : 0);
    }
}

/// Removes the plane unseen for longest if there is no room left. @return false if all are in sight
bool PlaneSet::make_room(WindowState& state) const {
    if (state.planes.size() < state.planes.capacity()) {
        return true;
    }
    const auto oldest = std::max_element(
        state.planes.begin(), state.planes.end(),
        [](const WindowPlane& a, const WindowPlane& b) { return a.unseen_keyframes < b.unseen_keyframes; });
    if (oldest->unseen_keyframes == 0) {
        return false;
    }
    remove(static_cast<int>(oldest - state.planes.begin()), state);
    return true;
}

void PlaneSet::admit(const PlaneProposal& proposal, WindowState& state, const WindowCameras& cameras) {
    if (is_refused(proposal.id) || !proposal.normal_W.allFinite() || std::abs(proposal.normal_W.norm() - 1.0) > 1e-3) {
        return;
    }
    const Plane at_origin = Plane::from(proposal.normal_W, proposal.distance_m, Eigen::Vector3d::Zero());
    int count = 0;
    int judged = 0;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
    for (const LandmarkId id : proposal.landmarks) {
        const Landmark* landmark = state.landmarks.find(id);
        if (landmark == nullptr || landmark->plane != Landmark::kNoPlane || !can_lie_on_planes(*landmark)) {
            continue;
        }
        ++judged;
        if (judge_fit(*landmark, at_origin, cameras) == Fit::kOn) {
            const Eigen::Vector3d p_W = position(*landmark, cameras);
            ++count;
            sum += p_W;
            squares += p_W * p_W.transpose();
        }
    }
    if (count < RegularityConfig::kMinConstraints || count < kLeastFitting * judged) {
        return;
    }
    const Eigen::Vector3d mean = sum / count;
    if (narrow_extent(squares - count * mean * mean.transpose(), count) < RegularityConfig::kMinExtent_m) {
        return;
    }
    if (!make_room(state)) {
        return;
    }
    WindowPlane plane;
    plane.id = proposal.id;
    plane.kind = proposal.kind;
    plane.plane = Plane::from(proposal.normal_W, proposal.distance_m, mean);
    plane.plane_lin = plane.plane;
    plane.constraints = count;
    state.planes.push_back(plane);
    state.prior.append_globals(kPlaneDim);
}

void PlaneSet::assign(const PlaneProposals& proposals, WindowState& state, const WindowCameras& cameras) const {
    for (int i = 0; i < state.landmarks.size(); ++i) {
        state.landmarks[i].proposed_plane = Landmark::kNoPlane;
    }
    for (int p = 0; p < static_cast<int>(state.planes.size()); ++p) {
        const PlaneProposal* proposal = find(proposals, state.planes[static_cast<std::size_t>(p)].id);
        if (proposal == nullptr) {
            continue;
        }
        for (const LandmarkId id : proposal->landmarks) {
            if (Landmark* landmark = state.landmarks.find(id)) {
                landmark->proposed_plane = p;
            }
        }
    }
    for (int i = 0; i < state.landmarks.size(); ++i) {
        Landmark& landmark = state.landmarks[i];
        const int proposed = landmark.proposed_plane;
        if (landmark.plane == proposed || landmark.plane_misfits >= kMaxLandmarkMisfits) {
            continue;
        }
        landmark.plane = Landmark::kNoPlane;
        if (proposed != Landmark::kNoPlane &&
            judge_fit(landmark, state.planes[static_cast<std::size_t>(proposed)].plane, cameras) == Fit::kOn) {
            landmark.plane = proposed;
        }
    }
}

/// How much each height counts, by the number of landmarks on its plane.
void PlaneSet::weigh(WindowState& state) const {
    std::array<int, kMaxPlanes> counts{};
    for (int i = 0; i < state.landmarks.size(); ++i) {
        const Landmark& landmark = state.landmarks[i];
        if (landmark.plane != Landmark::kNoPlane && landmark.is_active) {
            ++counts[static_cast<std::size_t>(landmark.plane)];
        }
    }
    for (std::size_t p = 0; p < state.planes.size(); ++p) {
        state.planes[p].sigma_m = config_.weigh_m(counts[p]);
    }
}

void PlaneSet::update(const PlaneProposals& proposals, WindowState& state, const WindowCameras& cameras) {
    for (Refusal& refusal : refused_) {
        refusal.left = std::max(0, refusal.left - 1);
    }
    for (int p = static_cast<int>(state.planes.size()) - 1; p >= 0; --p) {
        WindowPlane& plane = state.planes[static_cast<std::size_t>(p)];
        const PlaneProposal* const proposal = find(proposals, plane.id);
        const bool is_seen = proposal != nullptr;
        const bool is_idle = !is_seen || plane.constraints < RegularityConfig::kKeepConstraints;
        const bool is_lost = is_seen && plane.unseen_keyframes > 0 && has_moved(*proposal, plane.plane, state, cameras);
        plane.unseen_keyframes = is_seen ? 0 : plane.unseen_keyframes + 1;
        if ((!plane.is_bound && is_idle) || is_lost || is_refused(plane.id)) {
            remove(p, state);
        }
    }
    const auto is_known = [&](PlaneId id) {
        return std::any_of(state.planes.begin(), state.planes.end(), [&](const WindowPlane& p) { return p.id == id; });
    };
    for (const PlaneProposal& proposal : proposals) {
        if (!is_known(proposal.id)) {
            admit(proposal, state, cameras);
        }
    }
    assign(proposals, state, cameras);
    weigh(state);
}

void PlaneSet::judge(WindowState& state) {
    for (WindowPlane& plane : state.planes) {
        plane.constraints = 0;
        plane.mean_chi2 = 0.0;
    }
    for (int i = 0; i < state.landmarks.size(); ++i) {
        Landmark& landmark = state.landmarks[i];
        if (landmark.plane == Landmark::kNoPlane || !landmark.is_active) {
            continue;
        }
        WindowPlane& plane = state.planes[static_cast<std::size_t>(landmark.plane)];
        ++plane.constraints;
        plane.mean_chi2 += landmark.plane_chi2;
        if (landmark.plane_chi2 > RegularityConfig::kLeaveSigmas * RegularityConfig::kLeaveSigmas) {
            landmark.plane = Landmark::kNoPlane;
            ++landmark.plane_misfits;
        }
    }
    for (WindowPlane& plane : state.planes) {
        plane.mean_chi2 /= std::max(1, plane.constraints);
        plane.misfit_keyframes = plane.mean_chi2 > config_.max_plane_chi2 ? plane.misfit_keyframes + 1 : 0;
        if (plane.misfit_keyframes >= kMisfitKeyframes) {
            refuse(plane.id);  // leaves at the next keyframe
        }
    }
    align_planes(config_, state.planes);
}

}  // namespace facet
