// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/hole_filler.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "mesh/predicates.h"

namespace facet {
namespace {

// A hole in the mesh is filled if the vertices around it are within this distance of a plane (m).
constexpr double kHolePlanarity_m = 0.04;
/// Faces that have both vertices.
int faces_at_side(const HorizonMesh& mesh, VertexSlot a, VertexSlot b) {
    int count = 0;
    mesh.for_faces_of(a, [&](FaceIndex f) {
        const auto& v = mesh.face(f).vertex;
        count += v[0] == b || v[1] == b || v[2] == b ? 1 : 0;
    });
    return count;
}

/// Cosine of the smallest angle of a triangle: the smaller, the better its shape.
double worst_cosine(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
    const Eigen::Vector2d ab = (b - a).normalized();
    const Eigen::Vector2d bc = (c - b).normalized();
    const Eigen::Vector2d ca = (a - c).normalized();
    return std::max({-ab.dot(ca), -bc.dot(ab), -ca.dot(bc)});
}

}  // namespace

void HoleFiller::remember(const HorizonMesh& mesh, std::span<const VertexSlot> leaving) {
    for (const VertexSlot v : leaving) {
        state_[v] = Leaving::kYes;
    }
    for (const VertexSlot v : leaving) {
        Hole hole;
        Sides sides;
        if (state_[v] == Leaving::kYes && collect_group(mesh, v, sides, hole) && !holes_.full() &&
            close_ring(mesh, sides, hole)) {
            holes_.push_back(hole);
        }
    }
    for (const VertexSlot v : leaving) {
        state_[v] = Leaving::kNo;
    }
}

/// The leaving vertices that faces connect with the first one, and the border of their faces: the sides opposite a
/// leaving vertex whose ends stay, directed as the face is. @return false if there are none, or too many
bool HoleFiller::collect_group(const HorizonMesh& mesh, VertexSlot first, Sides& sides, Hole& hole) {
    hole.observations = 0xffff;
    bool one_plane = true;
    bool fits = true;
    group_.clear();
    group_.push_back(first);
    state_[first] = Leaving::kTaken;
    for (std::size_t g = 0; g < group_.size(); ++g) {
        mesh.for_faces_of(group_[g], [&](FaceIndex f) {
            const MeshFace& face = mesh.face(f);
            one_plane = one_plane && (hole.observations == 0xffff || face.plane == hole.plane);
            hole.plane = face.plane;
            hole.observations = std::min(hole.observations, face.observations);
            int staying = 0;
            std::size_t apex = 0;
            for (std::size_t k = 0; k < 3; ++k) {
                Leaving& state = state_[face.vertex[k]];
                if (state == Leaving::kYes) {
                    state = Leaving::kTaken;
                    group_.push_back(face.vertex[k]);
                }
                staying += state == Leaving::kNo ? 1 : 0;
                apex = state == Leaving::kNo ? apex : k;
            }
            if (staying == 2) {
                fits = fits && ok(sides.try_push_back({face.vertex[(apex + 1) % 3], face.vertex[(apex + 2) % 3]}));
            }
        });
    }
    hole.plane = one_plane ? hole.plane : PlaneId{};
    return fits && sides.size() >= 3;
}

/// The border as one line; false if it is open, or more than one.
bool HoleFiller::close_ring(const HorizonMesh& mesh, const Sides& sides, Hole& hole) {
    VertexSlot at = sides[0][0];
    for (std::size_t i = 0; i < sides.size(); ++i) {
        const auto from_here = [at](const std::array<VertexSlot, 2>& s) { return s[0] == at; };
        if (std::count_if(sides.begin(), sides.end(), from_here) != 1 || (i > 0 && at == sides[0][0])) {
            return false;
        }
        hole.landmark[hole.ring.size()] = mesh.landmark(at);
        hole.ring.push_back(at);
        at = (*std::find_if(sides.begin(), sides.end(), from_here))[1];
    }
    return at == sides[0][0];
}

bool HoleFiller::is_open(const HorizonMesh& mesh, const Hole& hole) {
    const std::size_t n = hole.ring.size();
    for (std::size_t i = 0; i < n; ++i) {
        if (!mesh.is_vertex(hole.ring[i]) || mesh.landmark(hole.ring[i]) != hole.landmark[i]) {
            return false;
        }
    }
    for (std::size_t i = 0; i < n; ++i) {
        if (faces_at_side(mesh, hole.ring[i], hole.ring[(i + 1) % n]) > 1) {
            return false;
        }
    }
    return true;
}

/// The ring in its plane; false if it is not flat enough.
bool HoleFiller::flatten(const HorizonMesh& mesh, const Hole& hole, std::array<Eigen::Vector2d, kMaxRing>& flat) {
    const std::size_t n = hole.ring.size();
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < n; ++i) {
        const Eigen::Vector3d a = mesh.vertex(hole.ring[i]).shown_W();
        centre += a / static_cast<double>(n);
        normal += (a - mesh.vertex(hole.ring[0]).shown_W()).cross(mesh.vertex(hole.ring[(i + 1) % n]).shown_W() - a);
    }
    if (!(normal.norm() > 1e-8)) {
        return false;
    }
    normal.normalize();
    const Eigen::Vector3d u = normal.unitOrthogonal();
    const Eigen::Vector3d v = normal.cross(u);
    const double tolerance = kHolePlanarity_m * (hole.plane.valid() ? 2.0 : 1.0);
    for (std::size_t i = 0; i < n; ++i) {
        const Eigen::Vector3d d = mesh.vertex(hole.ring[i]).shown_W() - centre;
        if (std::abs(normal.dot(d)) > tolerance) {
            return false;
        }
        flat[i] = {u.dot(d), v.dot(d)};
    }
    return true;
}

/// Ear clipping. A hole that cannot be closed within the limits stays as far open as it is.
int HoleFiller::triangulate(double max_side_m, std::uint32_t update, const Hole& hole,
                            const std::array<Eigen::Vector2d, kMaxRing>& flat, HorizonMesh& mesh) {
    FixedVector<std::size_t, kMaxRing> left;
    for (std::size_t i = 0; i < hole.ring.size(); ++i) {
        left.push_back(i);
    }
    int added = 0;
    while (left.size() >= 3) {
        const std::size_t n = left.size();
        std::size_t best = n;
        double best_cosine = 2.0;
        for (std::size_t i = 0; i < n; ++i) {
            const std::array<std::size_t, 3> ear{left[i], left[(i + 1) % n], left[(i + 2) % n]};
            bool is_ear = orientation(flat[ear[0]], flat[ear[1]], flat[ear[2]]) > 0.0;
            for (std::size_t k = 0; k < n && is_ear; ++k) {
                const std::size_t p = left[k];
                is_ear = p == ear[0] || p == ear[1] || p == ear[2] ||
                         orientation(flat[ear[0]], flat[ear[1]], flat[p]) < 0.0 ||
                         orientation(flat[ear[1]], flat[ear[2]], flat[p]) < 0.0 ||
                         orientation(flat[ear[2]], flat[ear[0]], flat[p]) < 0.0;
            }
            const double cosine = is_ear ? worst_cosine(flat[ear[0]], flat[ear[1]], flat[ear[2]]) : 2.0;
            if (cosine < best_cosine) {
                best_cosine = cosine;
                best = i;
            }
        }
        if (best == n) {
            return added;
        }
        const std::array<VertexSlot, 3> vertex{hole.ring[left[best]], hole.ring[left[(best + 1) % n]],
                                               hole.ring[left[(best + 2) % n]]};
        bool short_enough = true;
        for (std::size_t k = 0; k < 3; ++k) {
            const Eigen::Vector3d side = mesh.vertex(vertex[k]).shown_W() - mesh.vertex(vertex[(k + 1) % 3]).shown_W();
            short_enough = short_enough && side.norm() <= max_side_m;
        }
        if (short_enough) {
            if (const auto face = mesh.add_face(vertex); face.ok()) {
                MeshFace& f = mesh.face(face.value());
                f.born = f.last_observed = update;
                f.observations = hole.observations;
                f.plane = hole.plane;
                f.is_fill = true;
                ++added;
            }
        }
        left.erase_at((best + 1) % n);
    }
    return added;
}

HoleFiller::Filled HoleFiller::fill(double max_side_m, std::uint32_t update, HorizonMesh& mesh) {
    Filled filled;
    for (const Hole& hole : holes_) {
        std::array<Eigen::Vector2d, kMaxRing> flat;
        if (is_open(mesh, hole) && flatten(mesh, hole, flat)) {
            const int faces = triangulate(max_side_m, update, hole, flat, mesh);
            filled.holes += faces > 0 ? 1 : 0;
            filled.faces += faces;
        }
    }
    holes_.clear();
    return filled;
}

}  // namespace facet
