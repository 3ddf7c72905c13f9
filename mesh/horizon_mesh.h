// SPDX-License-Identifier: BSD-2-Clause
// The mesh over the horizon: vertices bound to landmarks, and the faces between them.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "mesh/capacity.h"
#include "platform/base/fixed_vector.h"
#include "platform/base/slot_pool.h"
#include "platform/base/timestamp.h"
#include "platform/base/typed_id.h"

namespace facet {

using VertexSlot = std::uint16_t;
using FaceIndex = std::uint16_t;

/// A vertex stands for a landmark, with which it moves and leaves the mesh, or for a surface point, which does both
/// with the keyframe that measured it. Faces, queries and files use the shown position; planes are judged by measured
/// ones, so that no plane confirms itself.
struct MeshVertex {
    Eigen::Vector3d measured_W = Eigen::Vector3d::Zero();    ///< position as measured (m)
    Eigen::Vector3d to_plane_W = Eigen::Vector3d::Zero();    ///< correction towards its plane (m); set by PlaneFinder
    Eigen::Matrix3f covariance_W = Eigen::Matrix3f::Zero();  ///< of measured_W given the poses (m^2)
    Timestamp first_stamp;                                   ///< oldest keyframe of the window that saw the landmark
    std::uint32_t last_updated = 0;                          ///< number of the update that last found the landmark
    bool is_surface_point = false;
    bool is_rehosted = false;                        ///< a surface point whose own keyframe is no more
    Eigen::Vector3d p_C0 = Eigen::Vector3d::Zero();  ///< of a surface point: in the left camera at first_stamp (m)

    /// Position as the mesh shows it: drawn to its plane if the estimator holds one there, else as measured (m).
    Eigen::Vector3d shown_W() const { return measured_W + to_plane_W; }
};

/// A triangle between three vertices; counterclockwise as seen from the side it was observed from, where its normal
/// points to.
struct MeshFace {
    std::array<VertexSlot, 3> vertex{};
    Eigen::Vector3f normal_W = Eigen::Vector3f::Zero();  ///< unit
    float area_m2 = 0.0F;
    float sigma_m = 0.0F;              ///< standard deviation along the normal, rms of the three vertices
    std::uint32_t born = 0;            ///< number of the update that made it: its age is the current one minus this
    std::uint32_t last_observed = 0;   ///< number of the last update whose triangulation had it,
    std::uint32_t last_confirmed = 0;  ///< and of the last one that accepted it; 0: none has (it closes a hole)
    std::uint16_t observations = 0;    ///< keyframes whose triangulation confirmed it, or the face it replaced
    std::uint16_t contradictions = 0;  ///< times something was seen behind it, or a step in it
    std::uint16_t doubts = 0;  ///< times what is in its place was refused for reasons that say nothing of the surface
    float unseen_s = 0.0F;     ///< for how long it has been in view, and neither confirmed nor covered
    bool is_fill = false;      ///< closes a hole, and no keyframe has shown it: the surface itself has left
                               ///< the horizon with other faces
    PlaneId plane;             ///< plane it belongs to; invalid if unknown

    /// Whether views have refused the face so often, for whatever reason, that it should speak neither for a plane nor
    /// for what is kept of the flight.
    bool is_doubtful() const {
        constexpr int kMinRefusals = 2;  // fewer say nothing
        return contradictions + doubts >= kMinRefusals && 4 * contradictions + doubts > 2 * observations;
    }
};

/// Up to kMaxMeshVertices vertices and kMaxMeshFaces faces; no two faces have the same three vertices. Faces and
/// vertices keep their index while they live; walking indices 0..face_end()-1 where is_face() holds visits all faces.
/// The faces at a vertex form a list. When full: adding is refused (kFull); the mesher makes room by its policy.
/// Thread-bound. No heap. About 1.2 MB.
class HorizonMesh {
public:
    static constexpr FaceIndex kNoFace = 0xffff;

    HorizonMesh() { clear(); }
    void clear();

    // Vertices.
    Result<VertexSlot> find_vertex(LandmarkId id) const;
    /// The landmark's vertex, new if need be; kFull, or kInvalidArgument for an invalid id.
    Result<VertexSlot> add_vertex(LandmarkId id);
    /// Contract: the vertex exists and has no faces.
    void remove_vertex(VertexSlot slot);
    bool is_vertex(int slot) const { return vertices_.used(static_cast<std::uint32_t>(slot)); }
    LandmarkId landmark(VertexSlot slot) const { return vertices_.id(slot); }
    MeshVertex& vertex(VertexSlot slot) { return vertices_[slot]; }
    const MeshVertex& vertex(VertexSlot slot) const { return vertices_[slot]; }
    int vertex_count() const { return static_cast<int>(vertices_.size()); }
    int vertex_end() const { return kMaxMeshVertices; }
    int faces_at(VertexSlot slot) const { return face_count_of_[slot]; }

    // Faces.
    /// Face with these vertices in any order, or kNoFace.
    FaceIndex find_face(const std::array<VertexSlot, 3>& vertex) const;
    /// Adds a face with normal, area and sigma computed.
    /// @return kFull; kInvalidArgument if it exists already or two vertices are the same; kDegenerate without area.
    Result<FaceIndex> add_face(const std::array<VertexSlot, 3>& vertex);
    /// Contract: is_face(index).
    void remove_face(FaceIndex index);
    bool is_face(int index) const { return index < face_end_ && alive_[static_cast<std::size_t>(index)]; }
    MeshFace& face(FaceIndex index) { return faces_[index]; }
    const MeshFace& face(FaceIndex index) const { return faces_[index]; }
    int face_count() const { return face_count_; }
    int face_end() const { return face_end_; }
    bool full() const { return face_count_ == kMaxMeshFaces; }
    /// Shown position of a corner (m).
    Eigen::Vector3d corner(const MeshFace& face, int k) const {
        return vertices_[face.vertex[static_cast<std::size_t>(k)]].shown_W();
    }
    Eigen::Vector3d centroid(const MeshFace& face) const {
        return (corner(face, 0) + corner(face, 1) + corner(face, 2)) / 3.0;
    }
    /// Turns a face round: its normal points to the other side.
    void turn(FaceIndex index);
    /// Recomputes normal, area and sigma from the vertices' shown positions.
    /// @return kDegenerate if the face has no area (face untouched)
    Status refresh(FaceIndex index);

    /// Calls visit(FaceIndex) for every face of a vertex; visit may remove that face, but no other.
    template <class Visit>
    void for_faces_of(VertexSlot slot, Visit visit) const {
        for (Corner c = first_corner_[slot]; c != kNoCorner;) {
            const Corner following = next_corner_[c];
            visit(static_cast<FaceIndex>(c / 3));
            c = following;
        }
    }

private:
    // Corner 3 f + k is vertex k of face f. The corners at a vertex form a list.
    using Corner = std::uint16_t;
    static constexpr Corner kNoCorner = 0xffff;
    static_assert(3 * kMaxMeshFaces < kNoCorner);
    static constexpr std::uint32_t kBuckets = 4 * kMaxMeshFaces;  // at most a quarter full
    using Key = std::array<VertexSlot, 3>;

    static Key key_of(Key vertex);
    static std::uint32_t home(const Key& key);
    std::uint32_t find_bucket(const Key& key) const;
    void unhash(std::uint32_t hole);
    void link(Corner corner, VertexSlot vertex);
    void unlink(Corner corner, VertexSlot vertex);

    SlotPool<LandmarkId, MeshVertex, kMaxMeshVertices> vertices_;
    std::array<Corner, kMaxMeshVertices> first_corner_{};
    std::array<std::uint16_t, kMaxMeshVertices> face_count_of_{};
    std::array<MeshFace, kMaxMeshFaces> faces_{};
    std::array<bool, kMaxMeshFaces> alive_{};
    std::array<Corner, 3 * kMaxMeshFaces> next_corner_{};
    std::array<Corner, 3 * kMaxMeshFaces> previous_corner_{};
    FixedVector<FaceIndex, kMaxMeshFaces> free_;
    std::array<FaceIndex, kBuckets> buckets_{};
    int face_count_ = 0;
    int face_end_ = 0;
};

}  // namespace facet
