// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/mesher.h"

#include <algorithm>

#include "estimator/geometry/inverse_depth.h"

namespace facet {
namespace {

// A landmark out of sight gives faces only if no other point is nearer to it in the image than this (px).
constexpr double kRecentDistance_px = 12.0;
// Nor if it has been out of sight for more keyframes than this.
constexpr int kRecentKeyframes = 4;
// Landmarks give no new faces if their standard deviation along the ray is larger (m).
constexpr double kMaxDepthSigma_m = 0.32;

}  // namespace

Status Mesher::configure(const MeshConfig& config, const CameraModel& left) {
    FACET_TRY(config.validate());
    camera_ = left;
    config_ = config;
    reset();
    return Status::kOk;
}

void Mesher::reset() {
    counters_ = {};
    update_ = 0;
    last_keyframes_.clear();
    mesh_.clear();
    holes_.clear();
    departed_.clear();
}

bool Mesher::is_usable(const LandmarkSnapshot& s, double slack) {
    return s.depth_sigma_m <= slack * kMaxDepthSigma_m && s.chi2 <= slack * kMaxChi2;
}

void Mesher::update(const KeyframeView& view, const ImageView& left) {
    ++update_;
    ++counters_.updates;
    departed_.clear();
    const CameraPose camera = CameraPose::from(view.T_W_C0);
    // A window always holds the keyframe before its newest one, unless it began in between.
    const bool is_first = update_ == 1 || view.oldest_stamp > last_stamp_;
    if (update_ > 1 && is_first) {
        leave_all();
    }
    const double since_last_s = is_first ? 0.0 : (view.stamp - last_stamp_).seconds();
    R_C_W_ = camera.R_C_W;
    constexpr double kMaxFlown_m = 2.0;  // the path between keyframes farther apart is not known
    const Eigen::Vector3d flown_C = R_C_W_ * (p_W_C_ - camera.p_W_C);
    flown_C_ = is_first || flown_C.norm() > kMaxFlown_m ? Eigen::Vector3d::Zero() : flown_C;
    p_W_C_ = camera.p_W_C;
    last_stamp_ = view.stamp;
    move_vertices(view);
    keep_poses(view);
    remove_leaving(view);
    refresh_faces();
    collect_tracked(view);
    triangulate();
    collect_recent(view);
    insert_recent();
    counters_.duplicate_points += static_cast<std::uint64_t>(delaunay_.duplicates());
    const std::span<const Triangle> triangles = delaunay_.triangles();
    filter_faces(config_.faces, triangles, {points_.data(), points_.size()}, left,
                 {verdicts_.data(), triangles.size()});
    merge();
    weigh_evidence(since_last_s);
    const HoleFiller::Filled filled = holes_.fill(config_.faces.max_side_m, update_, mesh_);
    counters_.holes_filled += static_cast<std::uint64_t>(filled.holes);
    counters_.fill_faces += static_cast<std::uint64_t>(filled.faces);
    prune_vertices();
}

DepartedFace Mesher::describe(const MeshFace& face) const {
    DepartedFace d;
    for (std::size_t k = 0; k < 3; ++k) {
        d.landmark[k] = mesh_.landmark(face.vertex[k]);
        d.p_W[k] = mesh_.vertex(face.vertex[k]).shown_W().cast<float>();
    }
    d.plane = face.plane;
    d.observations = face.observations;
    d.contradictions = face.contradictions;
    d.sigma_m = face.sigma_m;
    return d;
}

/// Geometry of all faces where their vertices are now; those that broke a limit go.
void Mesher::refresh_faces() {
    const double limit = config_.faces.max_flat_side_m * config_.faces.max_flat_side_m;
    for (int i = 0; i < mesh_.face_end(); ++i) {
        if (!mesh_.is_face(i)) {
            continue;
        }
        const auto f = static_cast<FaceIndex>(i);
        const MeshFace& face = mesh_.face(f);
        double longest = 0.0;
        for (int k = 0; k < 3; ++k) {
            longest = std::max(longest, (mesh_.corner(face, (k + 1) % 3) - mesh_.corner(face, k)).squaredNorm());
        }
        const Eigen::Vector3f side = face.normal_W;
        if (longest > limit || !ok(mesh_.refresh(f))) {
            ++counters_.misshapen;
            mesh_.remove_face(f);
        } else if (face.normal_W.dot(side) < 0.0F) {
            mesh_.turn(f);
            ++counters_.turned;
        }
    }
}

void Mesher::triangulate() {
    // Only invalid image coordinates are refused; this keyframe then adds nothing.
    static_cast<void>(delaunay_.triangulate({image_points_.data(), image_points_.size()}));
    locator_.build(delaunay_.triangles(), {image_points_.data(), image_points_.size()});
}

void Mesher::insert_recent() {
    static_cast<void>(delaunay_.insert({image_points_.data(), image_points_.size()}));
    locator_.build(delaunay_.triangles(), {image_points_.data(), image_points_.size()});
}

void Mesher::add_point(const LandmarkSnapshot& s, const Eigen::Vector3d& p_C, const Eigen::Vector2d& xy,
                       const Eigen::Vector2f& pixel) {
    const auto slot = mesh_.find_vertex(s.id);
    MeshPoint point;
    point.p_C = p_C;
    point.depth_sigma_m = s.depth_sigma_m;
    point.pixel = pixel;
    point.is_usable = is_usable(s, slot.ok() ? kHysteresis : 1.0) && p_C.z() > 0.0 && p_C.z() <= config_.max_depth_m;
    landmarks_.push_back({&s, slot.value_or(0), slot.ok()});
    image_points_.push_back(xy);
    points_.push_back(point);
    grid_.add(pixel);
}

/// All tracked landmarks take part in the triangulation, even those that no face may use: a far point between near ones
/// shows that there is no surface between them.
void Mesher::collect_tracked(const KeyframeView& view) {
    landmarks_.clear();
    image_points_.clear();
    points_.clear();
    grid_.clear(kRecentDistance_px, camera_.intrinsics().width, camera_.intrinsics().height);
    for (const LandmarkSnapshot& s : view.landmarks) {
        if (s.is_tracked && !landmarks_.full()) {
            add_point(s, R_C_W_ * (s.p_W - p_W_C_), s.left_xy, s.left_px);
        }
    }
    for (const LandmarkSnapshot& s : view.surface) {
        if (!landmarks_.full()) {
            add_point(s, R_C_W_ * (s.p_W - p_W_C_), s.left_xy, s.left_px);
            landmarks_.back().is_surface_point = true;
        }
    }
}

/// Landmarks that tracking lost a few keyframes ago, into the triangulation of the tracked ones.
void Mesher::collect_recent(const KeyframeView& view) {
    for (const LandmarkSnapshot& s : view.landmarks) {
        if (s.is_tracked || s.unseen_keyframes > kRecentKeyframes || s.keyframes < 2 || landmarks_.full()) {
            continue;
        }
        const Eigen::Vector3d p_C = R_C_W_ * (s.p_W - p_W_C_);
        Eigen::Vector2d uv;
        if (!is_usable(s, 1.0) || p_C.z() > config_.max_depth_m || !ok(camera_.project(p_C, uv)) ||
            !camera_.in_image(uv, 0.0)) {
            continue;
        }
        const Eigen::Vector2d xy = p_C.head<2>() / p_C.z();
        const Eigen::Vector2f pixel = uv.cast<float>();
        if (!grid_.has_near(pixel) && !is_hidden(s, p_C)) {
            add_point(s, p_C, xy, pixel);
        }
    }
}

/// Whether the tracked landmarks around a point show a surface in front of it, or behind it (seen through the point). A
/// point is used only if its depth is within the range of theirs.
bool Mesher::is_hidden(const LandmarkSnapshot& s, const Eigen::Vector3d& p_C) const {
    const int at = locator_.locate(p_C.head<2>() / p_C.z());
    if (at < 0) {
        return true;  // outside the hull of the tracked landmarks nothing confirms the point
    }
    double low = 1e300;
    double high = 0.0;
    for (const std::uint16_t p : delaunay_.triangles()[static_cast<std::size_t>(at)].point) {
        low = std::min(low, points_[p].p_C.z());
        high = std::max(high, points_[p].p_C.z());
    }
    const double margin = 3.0 * s.depth_sigma_m + kConflictMargin_m;
    return p_C.z() < low - margin || p_C.z() > high + margin;
}

/// Makes sure that the corners of a triangle are vertices; false if there is no room.
bool Mesher::add_corners(const Triangle& t) {
    for (const std::uint16_t p : t.point) {
        ImagePoint& point = landmarks_[p];
        if (point.has_vertex) {
            continue;
        }
        const auto slot = mesh_.add_vertex(point.landmark->id);
        if (!slot.ok()) {
            return false;
        }
        MeshVertex& vertex = mesh_.vertex(slot.value());
        vertex.measured_W = point.landmark->p_W;
        vertex.covariance_W = point.landmark->covariance_W;
        vertex.last_updated = update_;
        vertex.first_stamp = point.landmark->first_stamp;
        vertex.is_surface_point = point.is_surface_point;
        vertex.p_C0 = points_[p].p_C;
        point.vertex = slot.value();
        point.has_vertex = true;
    }
    return true;
}

void Mesher::merge() {
    const std::span<const Triangle> triangles = delaunay_.triangles();
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        ++counters_.verdicts[static_cast<std::size_t>(verdicts_[i])];
    }
    make_room(triangles.size());
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        face_of_triangle_[i] = HorizonMesh::kNoFace;
        const auto& p = triangles[i].point;
        const bool is_accepted = verdicts_[i] == FaceVerdict::kAccepted;
        if (is_accepted && !add_corners(triangles[i])) {
            ++counters_.refused;
            continue;
        }
        if (!(landmarks_[p[0]].has_vertex && landmarks_[p[1]].has_vertex && landmarks_[p[2]].has_vertex)) {
            continue;
        }
        // Counterclockwise in (x right, y down) is clockwise to the eye: the other way round faces the camera.
        const std::array<VertexSlot, 3> vertex{landmarks_[p[0]].vertex, landmarks_[p[2]].vertex,
                                               landmarks_[p[1]].vertex};
        const FaceIndex found = mesh_.find_face(vertex);
        if (found != HorizonMesh::kNoFace) {
            confirm(found, verdicts_[i], i);
        } else if (is_accepted) {
            if (const auto added = mesh_.add_face(vertex); added.ok()) {
                MeshFace& face = mesh_.face(added.value());
                face.born = face.last_observed = face.last_confirmed = update_;
                face.observations = 1;
                face_of_triangle_[i] = added.value();
                ++counters_.added;
            }
        }
    }
}

/// A triangle that is a face already, and what the filters say of it now.
void Mesher::confirm(FaceIndex f, FaceVerdict verdict, std::size_t triangle) {
    MeshFace& face = mesh_.face(f);
    const bool is_accepted = verdict == FaceVerdict::kAccepted;
    if (is_accepted && face.normal_W.cast<double>().dot(p_W_C_ - mesh_.centroid(face)) <= 0.0) {
        mesh_.turn(f);
        ++counters_.turned;
    }
    const bool is_step = verdict == FaceVerdict::kDepthStep || verdict == FaceVerdict::kGradient;
    std::uint16_t& count = is_accepted ? face.observations : is_step ? face.contradictions : face.doubts;
    count = static_cast<std::uint16_t>(std::min(count + 1, 0xffff));
    face.last_observed = update_;
    if (is_accepted) {
        face.last_confirmed = update_;
        face.is_fill = false;
        face.unseen_s = 0.0F;
        face_of_triangle_[triangle] = f;
        ++counters_.confirmed;
    }
}

/// Drops the least supported faces until `wanted` new ones fit.
void Mesher::make_room(std::size_t wanted) {
    const int excess = mesh_.face_count() + static_cast<int>(wanted) - kMaxMeshFaces;
    if (excess <= 0) {
        return;
    }
    std::size_t count = 0;
    for (int i = 0; i < mesh_.face_end(); ++i) {
        if (mesh_.is_face(i)) {
            order_[count++] = static_cast<FaceIndex>(i);
        }
    }
    const auto support = [this](FaceIndex f) {
        const MeshFace& face = mesh_.face(f);
        return face.observations - 2 * face.contradictions;
    };
    const auto nth = order_.begin() + std::min<std::ptrdiff_t>(excess, static_cast<std::ptrdiff_t>(count));
    std::nth_element(order_.begin(), nth, order_.begin() + static_cast<std::ptrdiff_t>(count),
                     [&](FaceIndex a, FaceIndex b) {
                         if (support(a) != support(b)) {
                             return support(a) < support(b);
                         }
                         const std::uint32_t seen_a = mesh_.face(a).last_observed;
                         const std::uint32_t seen_b = mesh_.face(b).last_observed;
                         return seen_a != seen_b ? seen_a < seen_b : a < b;
                     });
    for (auto f = order_.begin(); f != nth; ++f) {
        if (!mesh_.face(*f).is_fill && !departed_.full()) {
            departed_.push_back(describe(mesh_.face(*f)));
        }
        mesh_.remove_face(*f);
        ++counters_.dropped;
    }
}

bool Mesher::depth_prior(const Eigen::Vector2d& xy, DepthPrior& prior) const {
    const int at = update_ == 0 ? -1 : locator_.locate(xy);
    if (at < 0) {
        return false;
    }
    DepthPrior found{1e300, 0.0};
    for (const std::uint16_t p : delaunay_.triangles()[static_cast<std::size_t>(at)].point) {
        const double z = points_[p].p_C.z();
        if (!(z > 0.0)) {
            return false;
        }
        const double off = kHysteresis * points_[p].depth_sigma_m / (z * z);
        found.farthest = std::min(found.farthest, std::max(0.0, 1.0 / z - off));
        found.nearest = std::max(found.nearest, 1.0 / z + off);
    }
    prior = found;
    return true;
}

void Mesher::prune_vertices() {
    for (int i = 0; i < mesh_.vertex_end(); ++i) {
        if (mesh_.is_vertex(i) && mesh_.faces_at(static_cast<VertexSlot>(i)) == 0) {
            mesh_.remove_vertex(static_cast<VertexSlot>(i));
        }
    }
}

}  // namespace facet
