// SPDX-License-Identifier: BSD-2-Clause
// The true planes of a scene and the landmarks that truly lie on them, as proposals of a plane finder.
#pragma once

#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "app/lab/eval/mesh_accuracy.h"
#include "estimator/values/keyframe_view.h"

namespace facet {

/// A landmark is on the plane that its first sighting's ray meets. Where the plane is in the world of the estimate
/// follows from the newest keyframe's true and estimated pose. The estimator's gain from these proposals is the most
/// that planes can give on a log. Thread-bound. Heap.
class TruePlanes {
public:
    /// Ids of true planes begin here, out of the way of those that are found.
    static constexpr std::uint32_t kFirstId = 1U << 20U;

    /// @param path  planes.json beside the scene. Throws InputError if there is none, or no plane in it.
    explicit TruePlanes(const std::string& path);

    /// A landmark lies at p_W on the true surface, whose normal there is n_W.
    void see(LandmarkId landmark, const Eigen::Vector3d& p_W, const Eigen::Vector3d& n_W);

    /// Planes with at least kMinLandmarks of the view's landmarks, those with the most if there are too many.
    /// @param T_W_C0  true pose of the view's left camera
    const PlaneProposals& propose(const KeyframeView& view, const Se3& T_W_C0);

    static constexpr std::size_t kMinLandmarks = 6;

private:
    std::vector<EvalPlane> planes_;
    std::unordered_map<std::uint32_t, int> plane_of_;  ///< by landmark; none if it is on no plane
    PlaneProposals proposals_;
};

}  // namespace facet
