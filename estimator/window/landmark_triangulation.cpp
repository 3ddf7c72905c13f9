// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/landmark_triangulation.h"

#include <boost/container/static_vector.hpp>
#include <cmath>
#include <optional>

#include "estimator/geometry/triangulation.h"
#include "estimator/solver/landmark_schur.h"
#include "estimator/window/plain_loss.h"

namespace facet {
namespace {

using Sightings = boost::container::static_vector<Sighting, 2 * kMaxKeyframes>;

/// @param weights  that the sightings' whitening shall contain; empty: none
void collect_sightings(const Landmark& landmark, const WindowCameras& cameras, std::span<const Eigen::Vector2f> weights,
                       Sightings& out) {
    const int host = landmark.observations.front().keyframe;
    out.clear();
    for (std::size_t i = 0; i < landmark.observations.size(); ++i) {
        const LandmarkObservation& o = landmark.observations[i];
        const StereoView& view = cameras.view(o.keyframe, host);
        Eigen::Matrix2d left = cameras.whitening_left(o);
        if (!weights.empty()) {
            left *= std::sqrt(static_cast<double>(weights[i](0)));
        }
        out.push_back({&view.left, o.measurement.left_xy, left});
        if (o.measurement.has_right) {
            Eigen::Matrix2d right = cameras.whitening_right(o);
            if (!weights.empty()) {
                right *= std::sqrt(static_cast<double>(weights[i](1)));
            }
            out.push_back({&view.right, o.measurement.right_xy, right});
        }
    }
}

}  // namespace

bool triangulate_landmark(const WindowState& state, const WindowCameras& cameras, const RegularityConfig& regularity,
                          int steps, Landmark& landmark, std::span<const Eigen::Vector2f> weights) {
    Sightings sightings;
    collect_sightings(landmark, cameras, weights, sightings);
    TriangulationOptions options;
    options.loss = weights.empty() ? cameras.loss(landmark) : kPlainLoss;
    options.rho_prior_sigma = LandmarkSchur::kRhoBound;  // as it is eliminated
    std::optional<PlaneChart> plane;
    if (landmark.plane != Landmark::kNoPlane) {
        const WindowPlane& holder = state.planes[static_cast<std::size_t>(landmark.plane)];
        plane.emplace(holder.plane, cameras.left(landmark.observations.front().keyframe));
        options.plane = &*plane;
        options.plane_sigma_m = holder.sigma_m;
        options.plane_huber_threshold = regularity.huber_threshold;
    }
    options.max_iterations = steps;
    if (landmark.has_point && ok(triangulate({sightings.data(), sightings.size()}, options, landmark.point))) {
        return true;
    }
    if (!weights.empty()) {
        collect_sightings(landmark, cameras, {}, sightings);
    }
    const std::span<const Sighting> span(sightings.data(), sightings.size());
    options.loss = cameras.loss(landmark);
    options.rho_prior_sigma = kRhoPriorSigma;
    options.max_iterations = 8;
    InverseDepthPoint point;
    if (!ok(triangulate_linear(span, point)) || !ok(triangulate(span, options, point))) {
        return false;
    }
    landmark.point = point;
    landmark.has_point = true;
    return true;
}

}  // namespace facet
