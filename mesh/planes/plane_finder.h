// SPDX-License-Identifier: BSD-2-Clause
// Finds the floors, walls and slanted planes of the mesh, keeps their identity, and determines the landmarks on them.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

#include "estimator/values/keyframe_view.h"
#include "mesh/horizon_mesh.h"
#include "mesh/planes/plane_config.h"
#include "mesh/planes/plane_evidence.h"
#include "mesh/planes/plane_fit.h"
#include "mesh/planes/plane_memory.h"
#include "mesh/planes/plane_reach.h"
#include "mesh/planes/plane_votes.h"
#include "mesh/planes/slant_votes.h"
#include "platform/base/fixed_vector.h"

namespace facet {

/// A plane as the finder knows it.
struct TrackedPlane {
    PlaneSerial serial = 0;
    PlaneId id;  ///< invalid until confirmed; that of a plane which had left, if it is that one
    PlaneKind kind = PlaneKind::kHorizontal;
    PlaneId proposed;  ///< under which the estimator knows it
    PlaneFit fit;
    double area_m2 = 0.0;      ///< of its faces in the horizon
    int landmarks = 0;         ///< on it now
    int found = 0;             ///< keyframes that found it
    int lost = 0;              ///< keyframes in a row that did not
    int doubts = 0;            ///< keyframes in a row at which its landmarks did not form a plane
    bool is_held = false;      ///< a variable of the estimator, in sight or not: normal and distance are its own
    bool is_reported = false;  ///< among the last proposals
    PlaneReach reach;          ///< of all of it that was ever found
    SightedFrom from;          ///< when last found
};

/// Two ids that turned out to be of one plane: `gone` is used no more, what was under it belongs to `stays`, which is
/// older.
struct PlaneMerge {
    PlaneId gone;
    PlaneId stays;
};

/// What the finder has done since configure().
struct PlaneCounters {
    std::uint64_t candidates = 0;   ///< peaks examined
    std::uint64_t refused = 0;      ///< candidates that were no plane
    std::uint64_t confirmed = 0;    ///< planes that got an id
    std::uint64_t found_again = 0;  ///< lost planes that came back under their id
    std::uint64_t recalled = 0;     ///< new planes that turned out to be ones which had left
    std::uint64_t merged = 0;       ///< planes with an id merged into another one
    std::uint64_t doubted = 0;      ///< planes given up because their landmarks no longer formed one
    std::uint64_t forgotten = 0;    ///< planes lost for too long
    std::uint64_t crowded_out = 0;  ///< new planes for which there was no room
};

/// Finds planes in the mesh over the horizon without sampling [Rosinol19], at each keyframe after the mesher:
///   1 Known planes take their normal and distance from the estimator, or are refitted to their landmarks. Landmarks
///     that no longer fit leave; those of faces that lie in the plane join.
///   2 Planes that have become equal merge; the older id stays.
///   3 Faces that no plane explains vote for level and upright ones (PlaneVotes), and those still left for slanted ones
///     (SlantVotes); each peak is refined by weighted least squares.
///   4 A candidate becomes a plane if its landmarks form one, by number, area, extent, tilt and chi-square, without a
///     bend, a common trend of neighbouring residuals, or many neighbours off the plane. If it equals a known plane,
///     lost ones included, it is that plane; else it gets an id when found at `kConfirmKeyframes`.
/// Two planes are equal if one plane fits the landmarks of both, and if normal and distance, compared at each other's
/// landmarks, differ by no more than their uncertainty explains, within absolute limits. What joins a plane that is a
/// variable of the estimator has to lie on that as it is: the floor of the next room, half a degree off, would else
/// take its id, be held on it, be doubted, be lost, and be found again. A plane lost for more than
/// `kLeaveKeyframes` is no longer proposed, but followed for another `kForgetKeyframes`. At most kMaxPlanes have an
/// id: when full, the one lost for longest makes room; if none is lost, the new one waits. A new plane that is one
/// which has left, given the drift since (PlaneMemory), is that one, to the estimator as well; so is a plane that
/// leaves, and by then is known well enough to tell. Ids are never reused, not even after reset(). Time is bounded by
/// the capacities. About 2.2 MB: allocate it once. Thread-bound. Deterministic. No heap.
class PlaneFinder {
public:
    /// @return kInvalidArgument if a field is out of range (nothing changed). Forgets all planes; ids begin at 0.
    Status configure(const PlaneConfig& config);
    /// Forgets all planes: the estimator began a new window.
    void reset();

    /// Takes in a keyframe. A view that is not newer than the last one resets first.
    /// @param mesh  that the mesher has brought to this keyframe
    /// @return planes with at least three landmarks, until the next call
    const PlaneProposals& update(const HorizonMesh& mesh, const KeyframeView& view);

    /// Writes into every face the plane it lies on, invalid if none. Contract: the mesh as it was at the last update.
    void label(HorizonMesh& mesh) const;

    /// Sets MeshVertex::to_plane_W: draws vertices to their plane if the estimator holds it, as it has already done
    /// with its own landmarks, and removes the correction of all others. Measured positions are not touched. Contract:
    /// the mesh as it was at the last update.
    void flatten(HorizonMesh& mesh) const;

    /// All planes, by age; those without id are candidates.
    std::span<const TrackedPlane> planes() const { return {planes_.data(), planes_.size()}; }
    const PlaneProposals& proposals() const { return proposals_; }
    /// Ids that the last update() found to be of one plane, in the order in which that was found.
    std::span<const PlaneMerge> merges() const { return {merges_.data(), merges_.size()}; }
    const PlaneCounters& counters() const { return counters_; }
    /// A plane loses its id once: when it merges, or when it leaves.
    static constexpr int kMaxMerges = 2 * kMaxPlanes;

private:
    static constexpr int kMaxCandidates = 8;   // without id; and examined of one kind of votes
    static constexpr double kKeepSlack = 1.5;  // a known plane may miss the limits by this factor
    enum class Verdict { kPlane, kSmall, kMisshapen };

    PlaneGate join_gate() const { return {PlaneLimits::kJoin_m, PlaneLimits::kJoinSigmas}; }
    PlaneGate stay_gate() const { return {PlaneLimits::kStay_m, PlaneLimits::kStaySigmas}; }
    void take_estimates(const PlaneEstimates& estimates);
    void follow(TrackedPlane& plane);
    Verdict judge(PlaneKind kind, const PlaneFit& fit, const PlaneSupport& support, double slack) const;
    bool is_turned_as(PlaneKind kind, const PlaneFit& fit, double slack) const;
    double least_area(PlaneKind kind) const;
    bool is_supported(PlaneKind kind, const PlaneSupport& support, double slack) const;
    bool is_coherent(const PlaneFit& fit, const PlaneSupport& support, double slack) const;
    void search(const Eigen::Vector3d& origin_W);
    void examine(std::span<const PlanePeak> peaks);
    bool refine(const PlanePeak& peak, PlaneFit& fit);
    void adopt(PlaneKind kind, const PlaneFit& fit);
    bool may_be_same(const TrackedPlane& a, PlaneKind kind, const PlaneFit& fit) const;
    bool is_one(const TrackedPlane& known, std::span<const std::uint16_t> a, std::span<const std::uint16_t> b,
                const PlaneFit& start);
    void merge_equal();
    bool merge(TrackedPlane& older, const TrackedPlane& younger);
    void note_merge(PlaneId a, PlaneId b);
    void note_sightings();
    void retire();
    void remember(TrackedPlane& plane);
    void confirm();
    void identify(PlaneSerial serial);
    bool make_room();
    void propose();
    int confirmed() const;
    const TrackedPlane* find(PlaneSerial serial) const;  ///< nullptr if there is none

    PlaneConfig config_;
    PlaneCounters counters_;
    PlaneEvidence evidence_;
    PlaneVotes votes_;
    SlantVotes slants_;
    FixedVector<TrackedPlane, kMaxPlanes + kMaxCandidates> planes_;  ///< by serial
    PlaneMemory memory_;
    SightedFrom here_;  ///< the newest keyframe
    PlaneProposals proposals_;
    FixedVector<PlaneMerge, kMaxMerges> merges_;
    PlaneSupport support_;                              ///< scratch
    FixedVector<std::uint16_t, kMaxLandmarks> points_;  ///< scratch
    FixedVector<std::uint16_t, kMaxLandmarks> others_;  ///< scratch
    PlaneSerial next_serial_ = 1;
    std::uint32_t next_id_ = 0;
    std::uint32_t last_view_ = 0;
};

}  // namespace facet
