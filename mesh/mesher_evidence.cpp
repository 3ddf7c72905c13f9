// SPDX-License-Identifier: BSD-2-Clause
// Step 4 of the mesher: what the current keyframe says about faces that its triangulation does not have.
#include <algorithm>
#include <array>
#include <cmath>

#include "mesh/mesher.h"

namespace facet {
namespace {

constexpr double kSigmas = 3.0;
constexpr double kRelativeMargin = 0.02;  // of the depth: points this near to a face belong to it
constexpr double kInnerShare = 0.05;      // least barycentric coordinate of a point seen through a face
constexpr double kMaxCoarser = 2.5;       // a face is superseded by one of at most this many times its area
constexpr double kCornerShare = 0.95;     // part of the way from the middle to a corner up to which it is covered
constexpr double kMinDepth = 0.1;         // m

}  // namespace

int Mesher::triangle_at(const Eigen::Vector3d& p_C) const {
    return p_C.z() > kMinDepth ? locator_.locate(p_C.head<2>() / p_C.z()) : -1;
}

/// Whether a tracked point near the located triangle is seen behind the face.
bool Mesher::is_contradicted(const MeshFace& face, int triangle) const {
    const std::span<const Triangle> triangles = delaunay_.triangles();
    std::array<Eigen::Vector3d, 3> corner;
    for (std::size_t k = 0; k < 3; ++k) {
        corner[k] = vertex_C_[face.vertex[k]];
    }
    // A ray xy hits the face where sum b_k (corner_k) is parallel to (xy, 1): b from three determinants.
    const Eigen::Vector3d n0 = corner[1].cross(corner[2]);
    const Eigen::Vector3d n1 = corner[2].cross(corner[0]);
    const Eigen::Vector3d n2 = corner[0].cross(corner[1]);
    const double volume = corner[0].dot(n0);
    const auto is_behind = [&](std::uint16_t index) {
        const ImagePoint& tracked = landmarks_[index];
        if (tracked.has_vertex &&
            std::find(face.vertex.begin(), face.vertex.end(), tracked.vertex) != face.vertex.end()) {
            return false;
        }
        const MeshPoint& point = points_[index];
        const Eigen::Vector3d ray = image_points_[index].homogeneous();
        const Eigen::Vector3d b(ray.dot(n0), ray.dot(n1), ray.dot(n2));
        const double sum = b.sum();
        if (!(std::abs(sum) > 1e-12) || b.minCoeff() / sum < kInnerShare || b.maxCoeff() / sum > 1.0) {
            return false;
        }
        const double depth = volume / sum;
        const double margin = kSigmas * std::hypot(point.depth_sigma_m, static_cast<double>(face.sigma_m)) +
                              kRelativeMargin * depth + config_.conflict_margin_m;
        return depth > kMinDepth && tracked.landmark->is_tracked && tracked.landmark->keyframes >= 2 &&
               tracked.landmark->chi2 <= config_.max_chi2 && point.p_C.z() - depth > margin;
    };
    const Triangle& t = triangles[static_cast<std::size_t>(triangle)];
    for (std::size_t k = 0; k < 3; ++k) {
        if (is_behind(t.point[k])) {
            return true;
        }
        if (t.neighbour[k] >= 0) {
            for (const std::uint16_t p : triangles[static_cast<std::size_t>(t.neighbour[k])].point) {
                if (p != t.point[0] && p != t.point[1] && p != t.point[2] && is_behind(p)) {
                    return true;
                }
            }
        }
    }
    return false;
}

/// Whether the triangle's face is the same surface as the old face at one of the latter's points.
bool Mesher::is_covered_at(const MeshFace& face, const Eigen::Vector3d& p_C, int triangle) const {
    if (triangle < 0 || face_of_triangle_[static_cast<std::size_t>(triangle)] == HorizonMesh::kNoFace) {
        return false;
    }
    const MeshFace& other = mesh_.face(face_of_triangle_[static_cast<std::size_t>(triangle)]);
    if (other.area_m2 > kMaxCoarser * face.area_m2) {
        return false;
    }
    const Eigen::Vector3d normal = R_C_W_ * other.normal_W.cast<double>();
    const double distance = std::abs(normal.dot(p_C - vertex_C_[other.vertex[0]]));
    return distance < kSigmas * std::hypot(static_cast<double>(face.sigma_m), static_cast<double>(other.sigma_m)) +
                          0.5 * kRelativeMargin * p_C.z();
}

/// Whether newer faces of the same surface cover the face, at its middle and near each corner. Points nearer to the
/// middle are not enough: at the border of the view each keyframe would cut off the corners of the last one's faces.
bool Mesher::is_superseded(const MeshFace& face, int triangle) const {
    const Eigen::Vector3d middle =
        (vertex_C_[face.vertex[0]] + vertex_C_[face.vertex[1]] + vertex_C_[face.vertex[2]]) / 3.0;
    if (!is_covered_at(face, middle, triangle)) {
        return false;
    }
    for (const VertexSlot v : face.vertex) {
        const Eigen::Vector3d p = (1.0 - kCornerShare) * middle + kCornerShare * vertex_C_[v];
        if (!is_covered_at(face, p, triangle_at(p))) {
            return false;
        }
    }
    return true;
}

void Mesher::weigh_evidence() {
    for (int i = 0; i < mesh_.vertex_end(); ++i) {
        if (mesh_.is_vertex(i)) {
            const auto v = static_cast<VertexSlot>(i);
            vertex_C_[v] = R_C_W_ * (mesh_.vertex(v).shown_W() - p_W_C_);
        }
    }
    for (int i = 0; i < mesh_.face_end(); ++i) {
        if (!mesh_.is_face(i)) {
            continue;
        }
        const auto f = static_cast<FaceIndex>(i);
        MeshFace& face = mesh_.face(f);
        if (face.last_observed != update_) {
            const auto& v = face.vertex;
            const int triangle = triangle_at((vertex_C_[v[0]] + vertex_C_[v[1]] + vertex_C_[v[2]]) / 3.0);
            if (triangle < 0 || std::min({vertex_C_[v[0]].z(), vertex_C_[v[1]].z(), vertex_C_[v[2]].z()}) < kMinDepth) {
                continue;
            }
            if (is_superseded(face, triangle)) {
                MeshFace& newer = mesh_.face(face_of_triangle_[static_cast<std::size_t>(triangle)]);
                newer.observations = std::max(newer.observations, face.observations);
                ++counters_.superseded;
                mesh_.remove_face(f);
                continue;
            }
            face.contradictions =
                static_cast<std::uint16_t>(face.contradictions + (is_contradicted(face, triangle) ? 1 : 0));
        }
        if (face.contradictions >= config_.min_contradictions && 2 * face.contradictions > face.observations) {
            ++counters_.contradicted;
            mesh_.remove_face(f);
        }
    }
}

}  // namespace facet
