// SPDX-License-Identifier: BSD-2-Clause
// Builds the mesh over the receding horizon from the landmarks of each keyframe.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "estimator/geometry/camera_model.h"
#include "estimator/values/keyframe_view.h"
#include "mesh/delaunay.h"
#include "mesh/face_filter.h"
#include "mesh/hole_filler.h"
#include "mesh/horizon_mesh.h"
#include "mesh/mesh_config.h"
#include "mesh/point_grid.h"
#include "mesh/triangle_locator.h"
#include "platform/base/image_view.h"

namespace facet {

/// What the mesher has done since reset(): a counter for every way in which a triangle or face comes or goes.
struct MeshCounters {
    std::uint64_t updates = 0;
    std::array<std::uint64_t, static_cast<std::size_t>(FaceVerdict::kCount)>
        verdicts{};                      ///< of triangles, by FaceVerdict
    std::uint64_t duplicate_points = 0;  ///< tracked points at exactly the place of another one
    std::uint64_t added = 0;             ///< faces new in the mesh
    std::uint64_t confirmed = 0;         ///< triangles that were faces already
    std::uint64_t superseded = 0;        ///< faces replaced by newer ones of the same surface
    std::uint64_t contradicted = 0;      ///< faces removed because something was seen behind them, or a step in them
    std::uint64_t misshapen = 0;         ///< faces that became too long or lost their area as landmarks moved
    std::uint64_t judged_bad = 0;        ///< faces of landmarks that the smoother rejected or that became too uncertain
    std::uint64_t departed = 0;          ///< faces of landmarks that left the horizon
    std::uint64_t doubtful = 0;          ///< the same, but refused too often to be kept of the flight
    std::uint64_t dropped = 0;           ///< faces dropped because the mesh was full
    std::uint64_t refused = 0;           ///< accepted triangles for which the mesh had no room
    std::uint64_t aged = 0;              ///< of the departed: long in view, and no more confirmed
    std::uint64_t flown_through = 0;     ///< faces removed because the camera flew through them
    std::uint64_t turned = 0;            ///< faces turned round because they inverted or were seen from behind
    std::uint64_t rehosted = 0;          ///< surface points handed to another keyframe when theirs was dropped
    std::uint64_t holes_filled = 0;
    std::uint64_t fill_faces = 0;  ///< faces that fill holes
};

/// A face as it was when it left the horizon.
struct DepartedFace {
    std::array<LandmarkId, 3> landmark;
    std::array<Eigen::Vector3f, 3> p_W;  ///< shown positions (m)
    PlaneId plane;
    std::uint16_t observations = 0;
    std::uint16_t contradictions = 0;
    float sigma_m = 0.0F;
};

/// Between which inverse depths the corners lie of the triangle that a ray passes, their uncertainty included (1/m).
struct DepthPrior {
    double farthest = 0.0;
    double nearest = 0.0;
};

/// Incremental mesher [Rosinol19], called at each keyframe:
///   1 Vertices move with their landmarks. Landmarks that left the horizon, or were judged bad, take their faces along.
///     If the window restarted since the last keyframe, the whole mesh leaves: tracks may continue, but elsewhere.
///   2 The tracked landmarks are triangulated in the image (normalised, undistorted plane) and lifted. Beyond the paper
///     two more kinds of points join: surface points between the tracks, which move and leave with their keyframe (or
///     with its neighbour, if the window drops it as redundant), and landmarks lost from tracking a few keyframes ago,
///     where the tracked ones show nothing in front of them.
///   3 Triangles that pass the filters are merged into the mesh: a face that exists is confirmed, not doubled, and
///     turned round if it is seen from behind.
///   4 Older faces that are seen again as other triangles of the same surface are superseded by these. A face with
///     tracked points behind any part of it, or a step in depth in its triangle, is contradicted, and leaves when
///     contradicted often enough; a triangle that is refused for other reasons says nothing against its face. Faces
///     through which the camera has flown leave at once, and those long in view without being confirmed depart.
///   5 Holes that leaving landmarks left in surfaces are closed from their rings.
/// When the mesh is full, the least supported faces are dropped (fewest observations less contradictions, then longest
/// unseen). Time is bounded by the capacities. About 2 MB: allocate it once. Thread-bound. Deterministic. No heap.
class Mesher {
public:
    /// @return kInvalidArgument if a field is out of range (nothing changed). Forgets the mesh.
    Status configure(const MeshConfig& config, const CameraModel& left);
    void reset();

    /// Takes in a keyframe.
    /// @param left  its left image, or empty: then no gradient test
    void update(const KeyframeView& view, const ImageView& left);

    /// The camera that plays the left one from the next update on. No heap.
    void set_camera(const CameraModel& left) { camera_ = left; }

    /// What the last update's triangulation says of the depth along a ray: about the view of that keyframe.
    /// @param xy  normalised, undistorted
    /// @return whether the ray passes a triangle (prior untouched otherwise)
    bool depth_prior(const Eigen::Vector2d& xy, DepthPrior& prior) const;

    const HorizonMesh& mesh() const { return mesh_; }
    /// For the plane finder, which labels faces and corrects shown positions.
    HorizonMesh& mesh() { return mesh_; }
    /// Faces that left the horizon in the last update (not those judged bad, superseded or that only fill holes).
    std::span<const DepartedFace> departed() const { return {departed_.data(), departed_.size()}; }
    const MeshCounters& counters() const { return counters_; }
    /// The same description of a face that is still there.
    DepartedFace describe(const MeshFace& face) const;

private:
    /// A landmark that is a point of the current triangulation.
    struct ImagePoint {
        const LandmarkSnapshot* landmark = nullptr;
        VertexSlot vertex = 0;
        bool has_vertex = false;
        bool is_surface_point = false;
    };

    /// A landmark in use may be this much worse than a new one.
    static constexpr double kHysteresis = 1.5;
    /// Landmarks with larger squared residuals per degree of freedom, whose observations contradict each other, give no
    /// new faces and contradict none.
    static constexpr double kMaxChi2 = 4.0;
    /// A point contradicts what is in front of it, or behind it, by more than this, uncertainties added (m).
    static constexpr double kConflictMargin_m = 0.05;

    static bool is_usable(const LandmarkSnapshot& s, double slack);
    void leave_all();
    void move_vertices(const KeyframeView& view);
    const KeyframePose* find_host(const KeyframeView& view, MeshVertex& vertex);
    void keep_poses(const KeyframeView& view);
    void remove_leaving(const KeyframeView& view);
    void leave(VertexSlot slot, bool is_good);
    void depart(FaceIndex f);
    void report_departed(const MeshFace& face);
    void refresh_faces();
    void collect_tracked(const KeyframeView& view);
    void collect_recent(const KeyframeView& view);
    bool is_hidden(const LandmarkSnapshot& s, const Eigen::Vector3d& p_C) const;
    void add_point(const LandmarkSnapshot& s, const Eigen::Vector3d& p_C, const Eigen::Vector2d& xy,
                   const Eigen::Vector2f& pixel);
    void triangulate();
    void insert_recent();
    void merge();
    bool add_corners(const Triangle& t);
    void make_room(std::size_t wanted);
    void confirm(FaceIndex f, FaceVerdict verdict, std::size_t triangle);
    void collect_witnesses();
    void weigh_evidence(double since_last_s);
    bool judge_unseen(FaceIndex f, double since_last_s);
    bool is_contradicted(const MeshFace& face) const;
    bool is_flown_through(const MeshFace& face) const;
    bool is_superseded(const MeshFace& face, int triangle) const;
    bool is_same_surface(const MeshFace& face, const Eigen::Vector3d& p_C, int triangle) const;
    bool is_covered_at(const MeshFace& face, const Eigen::Vector3d& p_C, int triangle) const;
    int triangle_at(const Eigen::Vector3d& p_C) const;
    void prune_vertices();

    MeshConfig config_;
    CameraModel camera_;
    MeshCounters counters_;
    std::uint32_t update_ = 0;
    Timestamp last_stamp_;                                     ///< of the last update's keyframe
    FixedVector<KeyframePose, kMaxKeyframes> last_keyframes_;  ///< of the last update's view
    HorizonMesh mesh_;
    Delaunay delaunay_;
    TriangleLocator locator_;
    PointGrid grid_;  ///< of points_
    HoleFiller holes_;
    Eigen::Matrix3d R_C_W_ = Eigen::Matrix3d::Identity();
    Eigen::Vector3d p_W_C_ = Eigen::Vector3d::Zero();
    Eigen::Vector3d flown_C_ = Eigen::Vector3d::Zero();  ///< from the camera to where it was at the last update, in C
    FixedVector<std::uint16_t, kMaxMeshPoints> witnesses_;  ///< points that may contradict faces, by x in the image
    FixedVector<ImagePoint, kMaxMeshPoints> landmarks_;
    FixedVector<Eigen::Vector2d, kMaxMeshPoints> image_points_;
    FixedVector<MeshPoint, kMaxMeshPoints> points_;
    std::array<FaceVerdict, kMaxTriangles> verdicts_{};
    std::array<FaceIndex, kMaxTriangles> face_of_triangle_{};
    std::array<Eigen::Vector3d, kMaxMeshVertices> vertex_C_;  ///< vertices in the camera
    std::array<FaceIndex, kMaxMeshFaces> order_{};            ///< scratch of make_room
    FixedVector<VertexSlot, kMaxMeshVertices> leaving_;       ///< scratch of remove_leaving
    FixedVector<DepartedFace, kMaxMeshFaces> departed_;
};

}  // namespace facet
