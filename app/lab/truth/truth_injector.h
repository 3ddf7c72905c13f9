// SPDX-License-Identifier: BSD-2-Clause
// Puts the truth in the place of what was measured, to see what a measurement's errors cost.
#pragma once

#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "app/lab/eval/triangle_tree.h"
#include "app/lab/truth/true_planes.h"
#include "drivers/replay_asl/ground_truth.h"
#include "estimator/api/observation_hook.h"
#include "estimator/geometry/stereo_rig.h"
#include "estimator/values/observation.h"
#include "platform/base/samples.h"

namespace facet {

/// What is to be true.
struct TruthSelection {
    bool tracks = false;  ///< left pixels of a track: where the point of the surface appears that it began on
    bool stereo = false;  ///< right pixels: where the point of the surface appears that the left pixel shows
    bool bias = false;    ///< inertial samples, less their true biases
    bool planes = false;  ///< planes and their landmarks, in the place of those found in the mesh

    bool any() const { return tracks || stereo || bias || planes; }
    bool needs_surface() const { return tracks || stereo || planes; }
};

/// "tracks", "stereo", "bias" and "planes", with commas between. Throws InputError.
TruthSelection parse_truth(const std::string& text);

/// With true tracks the right pixel moves with the left one, so that the error of the stereo match stays; with true
/// stereo every point that both cameras see has a right pixel at keyframes, where the front-end looks for them. Points
/// that are hidden or were never on the surface stay as measured. Thread-bound. Heap.
class TruthInjector : public ObservationHook {
public:
    /// @param dataset  EuRoC/ASL folder with ground truth, with truth/scene.ply if tracks, stereo or planes are
    ///                 replaced, and for planes with truth/planes.json
    /// Throws InputError if something of that is missing.
    TruthInjector(const std::string& dataset, const StereoRig& rig, const TruthSelection& selection);

    void edit(Timestamp stamp, std::span<FeatureObservation> observations) override;
    void correct(ImuSample& sample) const;
    /// The proposals for the estimator at the keyframe of the last edit(): the true planes if they were selected, else
    /// `found`.
    const PlaneProposals& propose(const KeyframeView& view, const PlaneProposals& found);

private:
    struct Cameras {
        Se3 T_W_C0;
        Se3 T_W_C1;
    };
    std::optional<Eigen::Vector3d> surface_point(const Cameras& cameras, const Eigen::Vector2d& left_xy) const;
    bool project(const Eigen::Vector3d& p_W, const Se3& T_W_C, const CameraModel& camera, Eigen::Vector2d& xy) const;
    const std::optional<Eigen::Vector3d>& point_of(const Cameras& cameras, const FeatureObservation& observation);
    void put_on_track(const Cameras& cameras, FeatureObservation& observation);
    void put_in_stereo(const Cameras& cameras, FeatureObservation& observation) const;

    StereoRig rig_;
    TruthSelection selection_;
    std::vector<GroundTruthState> truth_;
    TriangleSoup surface_;
    std::optional<TriangleTree> tree_;
    std::optional<TruePlanes> planes_;
    std::optional<Se3> T_W_C0_;  ///< at the last edit()
    std::unordered_map<std::uint32_t, std::optional<Eigen::Vector3d>>
        points_;  ///< by landmark; empty: not on the surface
};

}  // namespace facet
