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
// A face is removed when at least this many keyframes contradict it and they are more than half as many as those that
// confirm it.
constexpr int kMinContradictions = 2;
// A face leaves after this time in view without being confirmed or covered by newer ones.
constexpr double kMaxUnseen_s = 5.0;

/// Where a face is in the image (normalised), as far as it is farther than kMinDepth ahead of the camera.
struct ImageBox {
    Eigen::Vector2d low = Eigen::Vector2d::Constant(1e300);
    Eigen::Vector2d high = Eigen::Vector2d::Constant(-1e300);

    void add(const Eigen::Vector3d& p_C) {
        const Eigen::Vector2d xy = p_C.head<2>() / p_C.z();
        low = low.cwiseMin(xy);
        high = high.cwiseMax(xy);
    }
    void add_side(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
        if (a.z() >= kMinDepth) {
            add(a);
        }
        if ((a.z() < kMinDepth) != (b.z() < kMinDepth)) {
            Eigen::Vector3d cut = a + (kMinDepth - a.z()) / (b.z() - a.z()) * (b - a);
            cut.z() = kMinDepth;
            add(cut);
        }
    }
};

}  // namespace

int Mesher::triangle_at(const Eigen::Vector3d& p_C) const {
    return p_C.z() > kMinDepth ? locator_.locate(p_C.head<2>() / p_C.z()) : -1;
}

/// Points that may contradict a face: tracked, and known from more than one view.
void Mesher::collect_witnesses() {
    witnesses_.clear();
    for (std::size_t i = 0; i < landmarks_.size(); ++i) {
        const LandmarkSnapshot& s = *landmarks_[i].landmark;
        if (s.is_tracked && s.keyframes >= 2 && s.chi2 <= kMaxChi2) {
            witnesses_.push_back(static_cast<std::uint16_t>(i));
        }
    }
    std::sort(witnesses_.begin(), witnesses_.end(), [this](std::uint16_t a, std::uint16_t b) {
        const double xa = image_points_[a].x();
        const double xb = image_points_[b].x();
        return xa != xb ? xa < xb : a < b;
    });
}

/// Whether any witness is seen behind any part of the face that lies ahead of the camera.
bool Mesher::is_contradicted(const MeshFace& face) const {
    const std::array<Eigen::Vector3d, 3> corner{vertex_C_[face.vertex[0]], vertex_C_[face.vertex[1]],
                                                vertex_C_[face.vertex[2]]};
    ImageBox box;
    for (std::size_t k = 0; k < 3; ++k) {
        box.add_side(corner[k], corner[(k + 1) % 3]);
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
                              kRelativeMargin * depth + kConflictMargin_m;
        return depth > kMinDepth && point.p_C.z() - depth > margin;
    };
    const auto* at = std::lower_bound(witnesses_.begin(), witnesses_.end(), box.low.x(),
                                      [this](std::uint16_t w, double x) { return image_points_[w].x() < x; });
    for (; at != witnesses_.end() && image_points_[*at].x() <= box.high.x(); ++at) {
        const double y = image_points_[*at].y();
        if (y >= box.low.y() && y <= box.high.y() && is_behind(*at)) {
            return true;
        }
    }
    return false;
}

/// Whether the camera has come nearer to the face than the body's radius since the last keyframe, on a straight line.
bool Mesher::is_flown_through(const MeshFace& face) const {
    const Eigen::Vector3d& a = vertex_C_[face.vertex[0]];
    const Eigen::Vector3d& b = vertex_C_[face.vertex[1]];
    const Eigen::Vector3d& c = vertex_C_[face.vertex[2]];
    // The path lies within this of the camera, the face within its longest side of a corner.
    const double reach = flown_C_.norm() + MeshConfig::kBodyRadius_m;
    if (a.norm() > reach + std::max((b - a).norm(), (c - a).norm())) {
        return false;
    }
    const Eigen::Vector3d normal = (R_C_W_ * face.normal_W.cast<double>()).normalized();
    const double here = -normal.dot(a);
    const double before = here + normal.dot(flown_C_);
    if (std::min(std::abs(here), std::abs(before)) > MeshConfig::kBodyRadius_m && here * before > 0.0) {
        return false;
    }
    // The path's point nearest to the plane; where it pierces the plane, that is the nearest to the face, too, unless
    // the path passes beside it.
    const double at = here * before <= 0.0 && here != before ? here / (here - before)
                                                             : (std::abs(before) < std::abs(here) ? 1.0 : 0.0);
    const Eigen::Vector3d p = at * flown_C_;
    const Eigen::Vector3d foot = p - normal.dot(p - a) * normal;
    const auto is_within = [&](const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
        return normal.dot((to - from).cross(foot - from)) >= -MeshConfig::kBodyRadius_m * (to - from).norm();
    };
    return is_within(a, b) && is_within(b, c) && is_within(c, a);
}

/// Whether the triangle's face is the same surface as the old face at one of the latter's points.
bool Mesher::is_same_surface(const MeshFace& face, const Eigen::Vector3d& p_C, int triangle) const {
    if (triangle < 0 || face_of_triangle_[static_cast<std::size_t>(triangle)] == HorizonMesh::kNoFace) {
        return false;
    }
    const MeshFace& other = mesh_.face(face_of_triangle_[static_cast<std::size_t>(triangle)]);
    const Eigen::Vector3d normal = R_C_W_ * other.normal_W.cast<double>();
    const double distance = std::abs(normal.dot(p_C - vertex_C_[other.vertex[0]]));
    return distance < kSigmas * std::hypot(static_cast<double>(face.sigma_m), static_cast<double>(other.sigma_m)) +
                          0.5 * kRelativeMargin * p_C.z();
}

/// Whether it is, and fine enough to stand for it.
bool Mesher::is_covered_at(const MeshFace& face, const Eigen::Vector3d& p_C, int triangle) const {
    return is_same_surface(face, p_C, triangle) &&
           mesh_.face(face_of_triangle_[static_cast<std::size_t>(triangle)]).area_m2 <= kMaxCoarser * face.area_m2;
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

/// What the keyframe says of the faces that its triangulation does not have.
void Mesher::weigh_evidence(double since_last_s) {
    for (int i = 0; i < mesh_.vertex_end(); ++i) {
        if (mesh_.is_vertex(i)) {
            const auto v = static_cast<VertexSlot>(i);
            vertex_C_[v] = R_C_W_ * (mesh_.vertex(v).shown_W() - p_W_C_);
        }
    }
    collect_witnesses();
    for (int i = 0; i < mesh_.face_end(); ++i) {
        if (!mesh_.is_face(i)) {
            continue;
        }
        const auto f = static_cast<FaceIndex>(i);
        MeshFace& face = mesh_.face(f);
        if (is_flown_through(face)) {
            ++counters_.flown_through;
            mesh_.remove_face(f);
            continue;
        }
        if (face.last_observed != update_ && judge_unseen(f, since_last_s)) {
            continue;
        }
        if (face.contradictions >= kMinContradictions && 2 * face.contradictions > face.observations) {
            ++counters_.contradicted;
            mesh_.remove_face(f);
        }
    }
}

/// A face that this keyframe's triangulation does not have. @return whether it was removed
bool Mesher::judge_unseen(FaceIndex f, double since_last_s) {
    MeshFace& face = mesh_.face(f);
    const auto& v = face.vertex;
    const double nearest = std::min({vertex_C_[v[0]].z(), vertex_C_[v[1]].z(), vertex_C_[v[2]].z()});
    const Eigen::Vector3d middle = (vertex_C_[v[0]] + vertex_C_[v[1]] + vertex_C_[v[2]]) / 3.0;
    const int triangle = nearest < kMinDepth ? -1 : triangle_at(middle);
    if (triangle >= 0 && is_superseded(face, triangle)) {
        MeshFace& newer = mesh_.face(face_of_triangle_[static_cast<std::size_t>(triangle)]);
        newer.observations = std::max(newer.observations, face.observations);
        ++counters_.superseded;
        mesh_.remove_face(f);
        return true;
    }
    if (is_contradicted(face)) {
        face.contradictions = static_cast<std::uint16_t>(std::min(face.contradictions + 1, 0xffff));
    } else if (triangle >= 0 && face_of_triangle_[static_cast<std::size_t>(triangle)] == HorizonMesh::kNoFace) {
        face.doubts = static_cast<std::uint16_t>(std::min(face.doubts + 1, 0xffff));
    }
    if (triangle >= 0 && middle.z() <= config_.max_depth_m) {
        face.unseen_s =
            is_same_surface(face, middle, triangle) ? 0.0F : face.unseen_s + static_cast<float>(since_last_s);
    }
    if (static_cast<double>(face.unseen_s) > kMaxUnseen_s) {
        ++counters_.aged;
        depart(f);
        return true;
    }
    return false;
}

}  // namespace facet
