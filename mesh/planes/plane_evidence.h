// SPDX-License-Identifier: BSD-2-Clause
// Points and faces of one keyframe as the plane finder sees them, and which plane has which of them.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

#include "estimator/values/keyframe_view.h"
#include "mesh/horizon_mesh.h"
#include "mesh/planes/plane_config.h"
#include "mesh/planes/plane_fit.h"
#include "mesh/planes/plane_votes.h"
#include "platform/base/fixed_vector.h"

namespace facet {

/// What a plane is called between its first candidate and its end; 0 for none.
using PlaneSerial = std::uint32_t;

/// How far a landmark may be from a plane.
struct PlaneGate {
    double distance_m = 0.0;
    double sigmas = 0.0;  ///< of landmark, plane and surface together
};

/// What speaks for a plane.
struct PlaneSupport {
    FixedVector<std::uint16_t, kMaxLandmarks> points;     ///< landmarks, increasing
    FixedVector<std::uint16_t, kMaxPlanePoints> surface;  ///< surface points, increasing
    double area_m2 = 0.0;                                 ///< of the faces with all corners on it
    double coherence = 0.0;    ///< by number, of the faces with two corners on it: those whose third is so too
    double roughness_m = 0.0;  ///< root of the covariance of residuals at two ends of a side; noise alone gives about 0
};

/// Points are the landmarks, by increasing id, and behind them the surface points of the mesh. Those bear faces, which vote and
/// cover area; what a plane is, and whether it is one, only landmarks say: seen from one keyframe, surface points are too
/// uncertain to contradict. About 1 MB. Thread-bound. No heap.
class PlaneEvidence {
public:
    void clear() { members_.clear(); }

    /// Landmarks and faces of this keyframe; landmarks keep the plane they had at the last one as their former plane.
    void take(const PlaneConfig& config, const HorizonMesh& mesh, const KeyframeView& view);

    std::span<const PlanePoint> points() const { return {points_.data(), points_.size()}; }
    LandmarkId landmark(std::uint16_t point) const { return state_[point].id; }
    PlaneSerial owner(std::uint16_t point) const { return state_[point].owner; }

    /// Landmarks on a plane: the corners of faces turned like it that lie on it with all three, and its former landmarks.
    /// Landmarks of other planes are left out. Coherence and roughness are weigh()'s.
    /// @param plane  whose former landmarks pass by `stay` and need no face; 0 for a candidate
    void collect(const PlaneFit& fit, PlaneSerial plane, const PlaneGate& join, const PlaneGate& stay,
                 PlaneSupport& support);
    /// Coherence and roughness of what the last collect() found.
    void weigh(PlaneSupport& support) const;
    /// Former landmarks of a plane, wherever they are.
    void collect_former(PlaneSerial plane, FixedVector<std::uint16_t, kMaxLandmarks>& points) const;
    /// Landmarks that a plane has now.
    void collect_owned(PlaneSerial plane, FixedVector<std::uint16_t, kMaxLandmarks>& points) const;

    void own(const PlaneSupport& support, PlaneSerial plane);
    void hand_over(PlaneSerial from, PlaneSerial to);
    void release(PlaneSerial plane) { hand_over(plane, 0); }
    /// Landmarks that no plane took at this keyframe are free for new ones.
    void forget_former();

    /// Faces that no plane explains vote.
    void vote(PlaneVotes& votes) const;

    /// At most kMaxPlaneLandmarks of the points, by increasing id: of each cell of a grid over the plane the ones told before
    /// and then the most certain first.
    void choose_spread(const PlaneFit& fit, std::span<const std::uint16_t> points,
                       FixedVector<LandmarkId, kMaxPlaneLandmarks>& chosen);

    /// Keeps who owns what until the next keyframe.
    void remember();

    /// Calls visit(face of the mesh, plane) for every face: the plane that its corners are on, 0 if none.
    /// @param fit_of  PlaneSerial -> const PlaneFit*
    template <class FitOf, class Visit>
    void for_faces(FitOf fit_of, Visit visit) const {
        for (const Face& f : faces_) {
            const PlaneSerial plane = majority(f);
            const PlaneFit* const fit = plane != 0 ? fit_of(plane) : nullptr;
            visit(f.index, fit != nullptr && lies_on(f, plane, *fit) ? plane : 0);
        }
    }

    /// Calls visit(vertex of the mesh, shift) for every vertex that is a point: from where it was measured to where it most
    /// likely is, given that it is on its plane; zero if it has none or the estimator has put it there.
    /// @param fit_of  PlaneSerial -> const PlaneFit*
    template <class FitOf, class Visit>
    void for_vertices(FitOf fit_of, Visit visit) const {
        for (std::size_t v = 0; v < point_of_vertex_.size(); ++v) {
            if (const std::uint16_t p = point_of_vertex_[v]; p != kNoPoint) {
                const PlaneFit* const fit = state_[p].owner != 0 ? fit_of(state_[p].owner) : nullptr;
                visit(static_cast<VertexSlot>(v), fit != nullptr && !state_[p].is_held
                                                      ? shift_to(*fit, points_[p])
                                                      : Eigen::Vector3d::Zero().eval());
            }
        }
    }

private:
    static constexpr std::uint16_t kNoPoint = 0xffff;
    struct PointState {
        LandmarkId id;
        PlaneSerial former = 0;
        PlaneSerial owner = 0;
        bool is_good = false;  ///< its sightings agree
        bool is_held = false;  ///< the estimator holds it on a plane
        bool was_told = false;
    };
    struct Member {
        LandmarkId id;
        PlaneSerial plane = 0;
        bool was_told = false;
    };
    struct Face {
        Eigen::Vector3f normal_W = Eigen::Vector3f::Zero();
        float area = 0.0F;
        Eigen::Vector3f centroid = Eigen::Vector3f::Zero();  ///< from origin_
        float tilt_sigma = 0.0F;                             ///< rad
        float least_cosine = 1.0F;                           ///< to the normal of a plane that it may be part of
        float sigma = 0.0F;                                  ///< m
        std::array<std::uint16_t, 3> point{};
        FaceIndex index = 0;
        bool is_fill = false;
    };
    /// A landmark against the plane in hand.
    struct Standing {
        float residual = 0.0F;
        float sigma = 0.0F;
        std::uint8_t fits = 0;  ///< 0 not yet asked, 1 yes, 2 no
        bool is_on = false;
    };

    void add_point(const PlanePoint& point, const PointState& state);
    void take_faces(const HorizonMesh& mesh);
    bool fits(std::uint16_t point, const PlaneFit& fit, PlaneSerial plane, const PlaneGate& join,
              const PlaneGate& stay);
    Eigen::Vector3d shift_to(const PlaneFit& fit, const PlanePoint& point) const;
    PlaneSerial majority(const Face& face) const;
    bool lies_on(const Face& face, PlaneSerial plane, const PlaneFit& fit) const;

    PlaneConfig config_;
    Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
    FixedVector<PlanePoint, kMaxPlanePoints> points_;
    std::size_t landmarks_ = 0;  ///< so many of the points are landmarks
    FixedVector<PointState, kMaxPlanePoints> state_;
    std::array<Eigen::Vector3f, kMaxPlanePoints> from_origin_;  ///< points, from origin_
    std::array<Standing, kMaxPlanePoints> standing_;
    std::array<std::uint16_t, kMaxMeshVertices> point_of_vertex_{};
    FixedVector<Face, kMaxMeshFaces> faces_;
    std::array<std::array<float, kMaxMeshFaces>, 3> place_;  ///< x, y and z of their centroids
    std::array<float, kMaxMeshFaces> height_;                ///< of these above the plane in hand
    FixedVector<std::uint16_t, kMaxMeshFaces> near_;         ///< faces near the plane in hand
    FixedVector<Member, kMaxLandmarks> members_;             ///< by increasing id, of the last keyframe
    struct Ranked {
        std::uint16_t point = 0;
        std::uint16_t cell = 0;
        std::uint16_t rank = 0;
        bool was_told = false;
        float sigma = 0.0F;
    };
    FixedVector<Ranked, kMaxLandmarks> ranked_;  ///< scratch of choose_spread
};

}  // namespace facet
