// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/truth/truth_injector.h"

#include <algorithm>
#include <sstream>

#include "app/lab/eval/scene_truth.h"
#include "app/support/input_error.h"

namespace facet {
namespace {

constexpr double kFarthestM = 200.0;
constexpr double kSurfaceMarginM = 0.01;  // a point is in sight if the ray to it ends this close

}  // namespace

TruthSelection parse_truth(const std::string& text) {
    TruthSelection selection;
    std::istringstream words(text);
    for (std::string word; std::getline(words, word, ',');) {
        if (word == "tracks") {
            selection.tracks = true;
        } else if (word == "stereo") {
            selection.stereo = true;
        } else if (word == "bias") {
            selection.bias = true;
        } else if (word == "planes") {
            selection.planes = true;
        } else {
            throw InputError("--truth " + text + ": must be tracks, stereo, bias and planes, with commas between");
        }
    }
    return selection;
}

TruthInjector::TruthInjector(const std::string& dataset, const StereoRig& rig, const TruthSelection& selection)
    : rig_(rig), selection_(selection) {
    const std::string table = find_ground_truth(dataset);
    std::string error;
    if (table.empty()) {
        throw InputError("--truth: " + dataset + " has no ground truth");
    }
    if (!ok(read_ground_truth(table, {}, truth_, error))) {
        throw InputError(error);
    }
    if (selection.bias && !truth_.front().has_motion) {
        throw InputError("--truth bias: " + table + " has no biases");
    }
    if (selection.needs_surface()) {
        surface_ = load_mesh(dataset + "/truth/scene.ply");
        tree_.emplace(surface_);
    }
    if (selection.planes) {
        planes_.emplace(dataset + "/truth/planes.json");
    }
}

std::optional<Eigen::Vector3d> TruthInjector::surface_point(const Cameras& cameras,
                                                            const Eigen::Vector2d& left_xy) const {
    const Eigen::Vector3d ray = cameras.T_W_C0.q * left_xy.homogeneous();
    const double depth = tree_->cast(cameras.T_W_C0.p, ray, kFarthestM);
    if (depth >= kFarthestM) {
        return std::nullopt;
    }
    return cameras.T_W_C0.p + depth * ray;
}

/// Whether a camera sees the point, and where.
bool TruthInjector::project(const Eigen::Vector3d& p_W, const Se3& T_W_C, const CameraModel& camera,
                            Eigen::Vector2d& xy) const {
    const Eigen::Vector3d p_C = T_W_C.inverse() * p_W;
    Eigen::Vector2d uv;
    if (p_C.z() <= 0.0 || !ok(camera.project(p_C, uv)) || !camera.in_image(uv, 0.0) ||
        tree_->blocks(T_W_C.p, p_W, kSurfaceMarginM)) {
        return false;
    }
    xy = p_C.hnormalized();
    return true;
}

/// The point of the surface that a track began on.
const std::optional<Eigen::Vector3d>& TruthInjector::point_of(const Cameras& cameras,
                                                              const FeatureObservation& observation) {
    const auto [entry, is_new] = points_.try_emplace(observation.landmark.value);
    if (is_new) {
        entry->second = surface_point(cameras, observation.left_xy);
        if (planes_ && entry->second.has_value()) {
            const int triangle = tree_->nearest(*entry->second, kSurfaceMarginM).triangle;
            if (triangle >= 0) {
                planes_->see(observation.landmark, *entry->second, surface_.normal(static_cast<std::size_t>(triangle)));
            }
        }
    }
    return entry->second;
}

void TruthInjector::put_on_track(const Cameras& cameras, FeatureObservation& observation) {
    const std::optional<Eigen::Vector3d>& p_W = point_of(cameras, observation);
    Eigen::Vector2d xy;
    if (p_W.has_value() && project(*p_W, cameras.T_W_C0, rig_.left, xy)) {
        observation.right_xy += xy - observation.left_xy;
        observation.left_xy = xy;
    }
}

void TruthInjector::put_in_stereo(const Cameras& cameras, FeatureObservation& observation) const {
    const std::optional<Eigen::Vector3d> p_W = surface_point(cameras, observation.left_xy);
    Eigen::Vector2d xy;
    if (p_W.has_value() && project(*p_W, cameras.T_W_C1, rig_.right, xy)) {
        observation.right_xy = xy;
        observation.has_right = true;
    }
}

void TruthInjector::edit(Timestamp stamp, std::span<FeatureObservation> observations) {
    const std::optional<GroundTruthState> at = interpolate(truth_, stamp);
    T_W_C0_.reset();
    if (!tree_ || !at) {
        return;
    }
    const Se3 T_W_B{at->q_W_B, at->p_W_B};
    const Cameras cameras{T_W_B * rig_.T_B_C0, T_W_B * rig_.T_B_C1};
    T_W_C0_ = cameras.T_W_C0;
    const bool has_stereo =
        std::any_of(observations.begin(), observations.end(), [](const FeatureObservation& o) { return o.has_right; });
    for (FeatureObservation& observation : observations) {
        if (selection_.tracks) {
            put_on_track(cameras, observation);
        } else if (selection_.planes) {
            point_of(cameras, observation);
        }
        if (selection_.stereo && has_stereo) {
            put_in_stereo(cameras, observation);
        }
    }
}

const PlaneProposals& TruthInjector::propose(const KeyframeView& view, const PlaneProposals& found) {
    return planes_ && T_W_C0_ ? planes_->propose(view, *T_W_C0_) : found;
}

void TruthInjector::correct(ImuSample& sample) const {
    if (!selection_.bias) {
        return;
    }
    if (const std::optional<GroundTruthState> at = interpolate(truth_, sample.stamp)) {
        sample.w_B -= at->gyro_bias;
        sample.a_B -= at->accel_bias;
    }
}

}  // namespace facet
