// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/flight/keyframe_snapshot.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "estimator/geometry/triangulation.h"
#include "estimator/window/landmark_triangulation.h"
#include "estimator/window/point_fit.h"
#include "estimator/window/window.h"

namespace facet {
namespace {

constexpr double kMinRho = 0.01;  // 1/m: farther than 100 m no baseline of the window gives a position

/// The landmark's point in the chart of its first keyframe: the window's own, or from one stereo match.
bool find_point(const Landmark& landmark, const WindowCameras& cameras, InverseDepthPoint& point) {
    if (landmark.is_active && landmark.has_point) {
        point = landmark.point;
        return true;
    }
    const LandmarkObservation& o = landmark.observations.front();
    if (landmark.observations.size() != 1 || !o.measurement.has_right) {
        return false;
    }
    const StereoView& view = cameras.view(o.keyframe, o.keyframe);
    const std::array<Sighting, 2> pair{Sighting{&view.left, o.measurement.left_xy, cameras.whitening_left(o)},
                                       Sighting{&view.right, o.measurement.right_xy, cameras.whitening_right(o)}};
    TriangulationOptions options;
    options.rho_prior_sigma = kRhoPriorSigma;
    return ok(triangulate_linear(pair, point)) && ok(triangulate(pair, options, point));
}

/// Fills everything of a snapshot but its pixel.
/// @param variance  of observations, in units of the one they are weighted with
/// @return false if the landmark has no usable position.
bool describe(const Landmark& landmark, const WindowState& state, const WindowCameras& cameras, double variance,
              LandmarkSnapshot& out) {
    InverseDepthPoint point;
    if (landmark.observations.empty() || !find_point(landmark, cameras, point) || point.rho < kMinRho) {
        return false;
    }
    out.id = landmark.id;
    out.p_W = ScaledWorldPoint(cameras.left(landmark.observations.front().keyframe), point).p_W();
    PointFit fit;
    if (!fit.add_all(landmark, cameras, out.p_W)) {
        return false;
    }
    out.stereo = fit.stereo;
    Eigen::Matrix3d covariance;
    bool invertible = false;
    fit.information.computeInverseWithCheck(covariance, invertible, 0.0);
    if (!invertible || !covariance.allFinite() || !out.p_W.allFinite()) {
        return false;
    }
    covariance *= variance;
    out.covariance_W = covariance.cast<float>();
    out.chi2 = static_cast<float>(fit.squared_error / (variance * std::max(1, fit.rows)));
    out.keyframes = static_cast<int>(landmark.observations.size());
    const int newest = static_cast<int>(state.keyframes.size()) - 1;
    out.first_stamp = state.keyframes[static_cast<std::size_t>(landmark.observations.front().keyframe)].stamp;
    const CameraPose& now = cameras.left(newest);
    const Eigen::Vector3d ray = out.p_W - now.p_W_C;
    out.depth_m = static_cast<float>(now.R_C_W.row(2).dot(ray));
    out.depth_sigma_m = static_cast<float>(std::sqrt(std::max(0.0, ray.dot(covariance * ray))) / (ray.norm() + 1e-9));
    const LandmarkObservation& last = landmark.observations.back();
    out.unseen_keyframes = newest - last.keyframe;
    out.is_tracked = out.unseen_keyframes == 0;
    out.left_xy = last.measurement.left_xy;
    if (landmark.plane != Landmark::kNoPlane) {
        out.plane = state.planes[static_cast<std::size_t>(landmark.plane)].id;
    }
    return true;
}

void fill_surface(const FrontendOutput& tracks, const WindowState& state, const WindowCameras& cameras, double variance,
                  KeyframeView& view) {
    view.surface.clear();
    Landmark seen;
    for (const FeatureObservation& o : tracks.surface) {
        seen.id = o.landmark;
        seen.observations.clear();
        seen.observations.push_back(cameras.observe(static_cast<int>(state.keyframes.size()) - 1, o));
        LandmarkSnapshot snapshot;
        if (describe(seen, state, cameras, variance, snapshot)) {
            snapshot.left_px = o.left_px;
            view.surface.push_back(snapshot);
        }
    }
}

}  // namespace

void fill_keyframe_view(const Window& window, const FrontendOutput& tracks, KeyframeView& view) {
    const WindowState& state = window.state();
    ++view.number;
    view.stamp = state.keyframes.back().stamp;
    view.oldest_stamp = state.keyframes.front().stamp;
    view.keyframes.clear();
    for (std::size_t k = 0; k < state.keyframes.size(); ++k) {
        const CameraPose& at = window.cameras().left(static_cast<int>(k));
        view.keyframes.push_back({state.keyframes[k].stamp, {Eigen::Quaterniond(at.R_C_W.transpose()), at.p_W_C}});
    }
    view.T_W_C0 = view.keyframes.back().T_W_C0;
    const VisionNoise& noise = window.cameras().noise();
    const double variance = std::pow(noise.cautious_px() / noise.sigma_px(), 2);
    view.observation_variance = std::clamp(std::pow(noise.measured_px() / noise.cautious_px(), 2), 0.05, 1.0);
    view.cameras.right = window.calibration().right;
    view.cameras.lens = window.calibration().lens;
    view.landmarks.clear();
    for (int i = 0; i < state.landmarks.size(); ++i) {
        LandmarkSnapshot snapshot;
        if (describe(state.landmarks[i], state, window.cameras(), variance, snapshot)) {
            view.landmarks.push_back(snapshot);
        }
    }
    fill_surface(tracks, state, window.cameras(), variance, view);
    view.planes.clear();
    for (const WindowPlane& p : state.planes) {
        view.planes.push_back({p.id, p.kind, p.plane.normal_W(), p.plane.distance_m(), p.constraints});
    }
    for (const FeatureObservation& o : tracks.observations) {
        const auto at = std::lower_bound(view.landmarks.begin(), view.landmarks.end(), o.landmark,
                                         [](const LandmarkSnapshot& s, LandmarkId id) { return s.id < id; });
        if (at != view.landmarks.end() && at->id == o.landmark && at->is_tracked) {
            at->left_px = o.left_px;
        }
    }
}

}  // namespace facet
