// SPDX-License-Identifier: BSD-2-Clause
// Points and faces of one keyframe for the plane finder, and the plane that each of them belongs to.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <span>

#include "estimator/values/keyframe_view.h"
#include "mesh/horizon_mesh.h"
#include "mesh/planes/plane_config.h"
#include "mesh/planes/plane_fit.h"
#include "mesh/planes/plane_votes.h"
#include "mesh/planes/slant_votes.h"
#include "platform/base/fixed_vector.h"

namespace facet {

/// Identifies a plane from its first candidate to its end; 0 for none.
using PlaneSerial = std::uint32_t;

/// How far a landmark may be from a plane.
struct PlaneGate {
    double distance_m = 0.0;
    double sigmas = 0.0;  ///< of landmark, plane and surface together
};

/// The evidence for a plane.
struct PlaneSupport {
    FixedVector<std::uint16_t, kMaxLandmarks> points;     ///< landmarks, increasing
    FixedVector<std::uint16_t, kMaxPlanePoints> surface;  ///< surface points, increasing
    double area_m2 = 0.0;                                 ///< of the faces with all corners on it
    double coherence = 0.0;        ///< share of the faces with two corners on it whose third corner is on it, too
    double known_coherence = 0.0;  ///< the same, less faces whose third corner is too uncertain to be on any plane
    double roughness_m = 0.0;  ///< root of the covariance of the residuals at both ends of a side; about 0 for noise
};

/// Points are the landmarks, by increasing id, followed by the surface points of the mesh, all at their measured
/// positions. Surface points are corners of faces, which vote and cover area. Where a plane is, and whether it is one,
/// is decided by landmarks alone: measured from one keyframe, surface points are too uncertain to contradict.
/// Thread-bound. No heap. About 1.3 MB.
class PlaneEvidence {
public:
    void clear() { members_.clear(); }

    /// Takes landmarks and faces of a keyframe; a landmark's plane at the last keyframe becomes its former plane.
    void take(const PlaneConfig& config, const HorizonMesh& mesh, const KeyframeView& view);

    std::span<const PlanePoint> points() const { return {points_.data(), points_.size()}; }
    LandmarkId landmark(std::uint16_t point) const { return state_[point].id; }
    PlaneSerial owner(std::uint16_t point) const { return state_[point].owner; }

    /// Landmarks on a plane: corners of faces that have its direction and all three corners on it, and former landmarks
    /// of the plane. Landmarks of other planes are left out. Coherence and roughness are computed by weigh().
    /// @param plane  its former landmarks have to pass only `stay` and need no face; 0 for a candidate
    void collect(const PlaneFit& fit, PlaneSerial plane, const PlaneGate& join, const PlaneGate& stay,
                 PlaneSupport& support);
    /// Coherence and roughness of the last collect()'s result.
    void weigh(PlaneSupport& support);
    /// Former landmarks of a plane, wherever they are.
    void collect_former(PlaneSerial plane, FixedVector<std::uint16_t, kMaxLandmarks>& points) const;
    /// Landmarks that a plane has now.
    void collect_owned(PlaneSerial plane, FixedVector<std::uint16_t, kMaxLandmarks>& points) const;

    void own(const PlaneSupport& support, PlaneSerial plane);
    void hand_over(PlaneSerial from, PlaneSerial to);
    void release(PlaneSerial plane) { hand_over(plane, 0); }
    /// Landmarks that belong to no plane at this keyframe become free for new ones.
    void forget_former();

    /// Lets the faces that no plane explains vote for level and upright ones.
    void vote(PlaneVotes& votes) const;
    /// The same for slanted ones.
    void vote(SlantVotes& votes) const;

    /// Chooses at most kMaxPlaneLandmarks of the points, evenly over the cells of a grid on the plane: in each cell
    /// those chosen before come first, then the most certain ones. @param chosen  by increasing id
    void choose_spread(const PlaneFit& fit, std::span<const std::uint16_t> points,
                       FixedVector<LandmarkId, kMaxPlaneLandmarks>& chosen);

    /// Keeps the planes of the landmarks until the next keyframe.
    void remember();

    /// Calls visit(face of the mesh, plane) for every face, with the plane that its corners are on or 0.
    /// @param fit_of  PlaneSerial -> const PlaneFit*
    template <class FitOf, class Visit>
    void for_faces(FitOf fit_of, Visit visit) const {
        for (const Face& f : faces_) {
            const PlaneSerial plane = majority(f);
            const PlaneFit* const fit = plane != 0 ? fit_of(plane) : nullptr;
            visit(f.index, fit != nullptr && lies_on(f, plane, *fit) ? plane : 0);
        }
    }

    /// Calls visit(vertex of the mesh, shift) for every vertex that is a point. The shift leads from the measured
    /// position to the most likely one on the vertex's plane; it is zero without a plane, and for landmarks that the
    /// estimator already holds on it.
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
        bool is_good = false;  ///< its sightings agree with each other
        bool is_held = false;  ///< the estimator holds it on a plane
        bool was_chosen = false;
    };
    struct Member {
        LandmarkId id;
        PlaneSerial plane = 0;
        bool was_chosen = false;
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
    /// Whether a point fits the plane being examined.
    enum class Fits : std::uint8_t { kUnknown, kYes, kNo };

    void add_point(const PlanePoint& point, const PointState& state);
    void take_faces(const HorizonMesh& mesh);
    /// The plane being examined, and what its points have to pass.
    struct Examined {
        const PlaneFit& fit;
        Eigen::Vector3f normal_W;
        float from_origin_m = 0.0F;  ///< distance of the plane from origin_
        float farthest_m = 0.0F;     ///< beyond, no gate lets a point pass
        PlaneSerial plane = 0;
        PlaneGate join;
        PlaneGate stay;
    };
    /// Calls visit(index) for each of the flags that is 1. The others are 0, also from `count` on to the next multiple
    /// of eight.
    template <class Visit>
    static void for_set(const std::uint8_t* flags, std::size_t count, Visit visit) {
        for (std::size_t begin = 0; begin < count; begin += 8) {
            std::uint64_t eight = 0;
            std::memcpy(&eight, flags + begin, 8);
            if (eight == 0) {
                continue;
            }
            std::array<std::size_t, 8> set;
            std::size_t found = 0;
            for (std::size_t i = begin; i < begin + 8; ++i) {
                set[found] = i;
                found += flags[i];
            }
            std::for_each_n(set.begin(), found, visit);
        }
    }
    void find_parallel_near(const Examined& examined);
    bool fits(std::uint16_t point, const Examined& examined) {
        if (fits_[point] == Fits::kUnknown) {
            fits_[point] = test(point, examined) ? Fits::kYes : Fits::kNo;
        }
        return fits_[point] == Fits::kYes;
    }
    bool test(std::uint16_t point, const Examined& examined);
    bool is_explained(const Face& face) const;
    Eigen::Vector3d shift_to(const PlaneFit& fit, const PlanePoint& point) const;
    PlaneSerial majority(const Face& face) const;
    bool lies_on(const Face& face, PlaneSerial plane, const PlaneFit& fit) const;

    PlaneConfig config_;
    Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
    FixedVector<PlanePoint, kMaxPlanePoints> points_;
    std::size_t landmarks_ = 0;  ///< number of points that are landmarks: the first ones
    FixedVector<PointState, kMaxPlanePoints> state_;
    std::array<Eigen::Vector3f, kMaxPlanePoints> from_origin_;  ///< points, from origin_
    // Of points, relative to the plane being examined.
    std::array<Fits, kMaxPlanePoints> fits_;
    std::array<std::uint8_t, kMaxPlanePoints> is_on_;      ///< 0 or 1; zero up to a multiple of 8
    std::array<float, kMaxPlanePoints> residual_;          ///< of those that fit
    std::array<double, kMaxPlanePoints> variance_;         ///< likewise, without that of the plane (m^2)
    std::array<float, kMaxPlanePoints> sigma_;             ///< of those that are on it; set by weigh()
    Eigen::Vector3f normal_W_ = Eigen::Vector3f::UnitZ();  ///< of that plane
    std::array<std::uint16_t, kMaxMeshVertices> point_of_vertex_{};
    FixedVector<Face, kMaxMeshFaces> faces_;
    // Of faces, side by side for the loop that looks at all of them.
    std::array<std::array<float, kMaxMeshFaces>, 3> place_;   ///< x, y and z of their centroids
    std::array<std::array<float, kMaxMeshFaces>, 3> facing_;  ///< x, y and z of their normals
    std::array<float, kMaxMeshFaces> least_cosine_;
    std::array<std::array<std::uint16_t, 3>, kMaxMeshFaces> corner_;  ///< their points
    std::array<float, kMaxMeshFaces> height_;           ///< of the centroids above the plane being examined
    std::array<std::uint16_t, kMaxMeshFaces> near_;     ///< scratch of weigh()
    std::array<std::uint8_t, kMaxMeshFaces> is_along_;  ///< near the plane being examined, and turned like it
    FixedVector<Member, kMaxLandmarks> members_;        ///< by increasing id, of the last keyframe
    struct Ranked {
        std::uint16_t point = 0;
        std::uint16_t cell = 0;
        std::uint16_t rank = 0;
        bool was_chosen = false;
        float sigma = 0.0F;
    };
    FixedVector<Ranked, kMaxLandmarks> ranked_;  ///< scratch of choose_spread
};

}  // namespace facet
