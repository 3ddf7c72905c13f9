// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/window/landmark_triangulation.h"

#include <boost/container/static_vector.hpp>
#include <optional>
#include <span>

#include "estimator/geometry/triangulation.h"

namespace facet {

bool triangulate_landmark(const WindowState& state, const WindowCameras& cameras, const RegularityConfig& regularity,
                          int steps, Landmark& landmark) {
    const int host = landmark.observations.front().keyframe;
    boost::container::static_vector<Sighting, 2 * kMaxKeyframes> sightings;
    for (const LandmarkObservation& o : landmark.observations) {
        const StereoView& view = cameras.view(o.keyframe, host);
        sightings.push_back({&view.left, o.measurement.left_xy, cameras.whitening_left(o)});
        if (o.measurement.has_right) {
            sightings.push_back({&view.right, o.measurement.right_xy, cameras.whitening_right(o)});
        }
    }
    const std::span<const Sighting> span(sightings.data(), sightings.size());
    TriangulationOptions options;
    options.loss = cameras.loss();
    options.rho_prior_sigma = kRhoPriorSigma;
    std::optional<PlaneChart> plane;
    if (landmark.plane != Landmark::kNoPlane) {
        const WindowPlane& holder = state.planes[static_cast<std::size_t>(landmark.plane)];
        plane.emplace(holder.plane, cameras.left(host));
        options.plane = &*plane;
        options.plane_sigma_m = holder.sigma_m;
        options.plane_huber_threshold = regularity.huber_threshold;
    }
    options.max_iterations = steps;
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

}  // namespace facet
