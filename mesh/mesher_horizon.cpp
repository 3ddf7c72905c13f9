// SPDX-License-Identifier: BSD-2-Clause
// Step 1 of the mesher: vertices move with the window, and what has left it departs.
#include <algorithm>
#include <cstdint>

#include "mesh/mesher.h"

namespace facet {
namespace {

const KeyframePose* find_keyframe(const FixedVector<KeyframePose, kMaxKeyframes>& keyframes, Timestamp stamp) {
    const auto* const at = std::lower_bound(keyframes.begin(), keyframes.end(), stamp,
                                            [](const KeyframePose& k, Timestamp s) { return k.stamp < s; });
    return at != keyframes.end() && at->stamp == stamp ? at : nullptr;
}

}  // namespace

void Mesher::leave_all() {
    for (int i = 0; i < mesh_.face_end(); ++i) {
        if (mesh_.is_face(i)) {
            report_departed(mesh_.face(static_cast<FaceIndex>(i)));
        }
    }
    mesh_.clear();
    last_keyframes_.clear();
}

void Mesher::move_vertices(const KeyframeView& view) {
    for (const LandmarkSnapshot& s : view.landmarks) {
        const auto slot = mesh_.find_vertex(s.id);
        if (slot.ok() && is_usable(s, kHysteresis)) {
            MeshVertex& vertex = mesh_.vertex(slot.value());
            vertex.measured_W = s.p_W;
            vertex.covariance_W = s.covariance_W;
            vertex.last_updated = update_;
            vertex.first_stamp = s.first_stamp;
        }
    }
    for (int i = 0; i < mesh_.vertex_end(); ++i) {
        if (!mesh_.is_vertex(i) || !mesh_.vertex(static_cast<VertexSlot>(i)).is_surface_point) {
            continue;
        }
        MeshVertex& vertex = mesh_.vertex(static_cast<VertexSlot>(i));
        if (const KeyframePose* const host = find_host(view, vertex); host != nullptr) {
            vertex.measured_W = host->T_W_C0 * vertex.p_C0;
            vertex.last_updated = update_;
        }
    }
}

/// The keyframe that a surface point moves with, or null if the point leaves. If the window has dropped its keyframe
/// as redundant, the point is handed to the nearest keyframe that was there already, relative to which it stays as the
/// last view had the two.
const KeyframePose* Mesher::find_host(const KeyframeView& view, MeshVertex& vertex) {
    const KeyframePose* const own = find_keyframe(view.keyframes, vertex.first_stamp);
    if (own != nullptr || vertex.first_stamp < view.oldest_stamp) {
        return own;
    }
    const KeyframePose* host = nullptr;
    const KeyframePose* host_before = nullptr;
    std::int64_t least_ns = INT64_MAX;
    for (const KeyframePose& kept : view.keyframes) {
        const std::int64_t apart_ns = std::abs((kept.stamp - vertex.first_stamp).ns);
        const KeyframePose* const before = find_keyframe(last_keyframes_, kept.stamp);
        if (before != nullptr && apart_ns < least_ns) {
            least_ns = apart_ns;
            host = &kept;
            host_before = before;
        }
    }
    if (host != nullptr) {
        vertex.p_C0 = host_before->T_W_C0.inverse() * vertex.measured_W;
        vertex.first_stamp = host->stamp;
        vertex.is_rehosted = true;
        ++counters_.rehosted;
    }
    return host;
}

void Mesher::keep_poses(const KeyframeView& view) {
    last_keyframes_.clear();
    for (const KeyframePose& keyframe : view.keyframes) {
        last_keyframes_.push_back(keyframe);
    }
}

/// A landmark that is gone has left the horizon if the oldest keyframe that saw it has; else it was judged bad.
void Mesher::remove_leaving(const KeyframeView& view) {
    const auto is_leaving = [&](int i) {
        return mesh_.is_vertex(i) && mesh_.vertex(static_cast<VertexSlot>(i)).last_updated != update_;
    };
    const auto is_good = [&](int i) {
        return mesh_.vertex(static_cast<VertexSlot>(i)).first_stamp < view.oldest_stamp;
    };
    leaving_.clear();
    for (int i = 0; i < mesh_.vertex_end(); ++i) {
        if (is_leaving(i) && is_good(i)) {
            leaving_.push_back(static_cast<VertexSlot>(i));
        }
    }
    holes_.remember(mesh_, {leaving_.data(), leaving_.size()});
    for (int i = 0; i < mesh_.vertex_end(); ++i) {
        if (is_leaving(i)) {
            leave(static_cast<VertexSlot>(i), is_good(i));
        }
    }
}

void Mesher::leave(VertexSlot slot, bool is_good) {
    mesh_.for_faces_of(slot, [&](FaceIndex f) {
        if (is_good) {
            depart(f);
        } else {
            ++counters_.judged_bad;
            mesh_.remove_face(f);
        }
    });
    mesh_.remove_vertex(slot);
}

/// Removes a face that has left the horizon.
void Mesher::depart(FaceIndex f) {
    report_departed(mesh_.face(f));
    mesh_.remove_face(f);
}

/// While a face is in view, only geometry removes it. What is kept of the flight asks for more: that more triangles
/// have confirmed it than were refused in its place, for whatever reason.
void Mesher::report_departed(const MeshFace& face) {
    if (face.is_doubtful()) {
        ++counters_.doubtful;
        return;
    }
    ++counters_.departed;
    if (!face.is_fill && !departed_.full()) {
        departed_.push_back(describe(face));
    }
}

}  // namespace facet
