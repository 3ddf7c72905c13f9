// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/horizon_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

namespace facet {
namespace {

constexpr double kMinArea = 1e-8;  // m^2

}  // namespace

void HorizonMesh::clear() {
    vertices_.clear();
    first_corner_.fill(kNoCorner);
    face_count_of_.fill(0);
    alive_.fill(false);
    free_.clear();
    buckets_.fill(kNoFace);
    face_count_ = 0;
    face_end_ = 0;
}

Result<VertexSlot> HorizonMesh::find_vertex(LandmarkId id) const {
    const auto slot = vertices_.find(id);
    if (!slot.ok()) {
        return slot.status();
    }
    return static_cast<VertexSlot>(slot.value());
}

Result<VertexSlot> HorizonMesh::add_vertex(LandmarkId id) {
    const auto found = vertices_.find(id);
    if (found.ok()) {
        return static_cast<VertexSlot>(found.value());
    }
    const auto slot = vertices_.insert(id);
    if (!slot.ok()) {
        return slot.status();
    }
    first_corner_[slot.value()] = kNoCorner;
    face_count_of_[slot.value()] = 0;
    return static_cast<VertexSlot>(slot.value());
}

void HorizonMesh::remove_vertex(VertexSlot slot) {
    FACET_ASSERT(face_count_of_[slot] == 0);
    FACET_ASSERT(ok(vertices_.erase(vertices_.id(slot))));
}

HorizonMesh::Key HorizonMesh::key_of(Key vertex) {
    std::sort(vertex.begin(), vertex.end());
    return vertex;
}

/// Three slots of 12 bits, multiplied by 2^64 / golden ratio.
std::uint32_t HorizonMesh::home(const Key& key) {
    const std::uint64_t packed = (std::uint64_t{key[0]} << 24U) | (std::uint64_t{key[1]} << 12U) | key[2];
    static_assert(kMaxMeshVertices <= 1 << 12);
    return static_cast<std::uint32_t>((packed * 0x9e3779b97f4a7c15ULL) >> 40U) % kBuckets;
}

/// Bucket of the face with this key, or the empty one where it would go.
std::uint32_t HorizonMesh::find_bucket(const Key& key) const {
    std::uint32_t bucket = home(key);
    while (buckets_[bucket] != kNoFace && key_of(faces_[buckets_[bucket]].vertex) != key) {
        bucket = (bucket + 1) % kBuckets;
    }
    return bucket;
}

FaceIndex HorizonMesh::find_face(const std::array<VertexSlot, 3>& vertex) const {
    return buckets_[find_bucket(key_of(vertex))];
}

Result<FaceIndex> HorizonMesh::add_face(const std::array<VertexSlot, 3>& vertex) {
    const Key key = key_of(vertex);
    if (key[0] == key[1] || key[1] == key[2]) {
        return Status::kInvalidArgument;
    }
    const std::uint32_t bucket = find_bucket(key);
    if (buckets_[bucket] != kNoFace) {
        return Status::kInvalidArgument;
    }
    if (full()) {
        return Status::kFull;
    }
    const FaceIndex index = free_.empty() ? static_cast<FaceIndex>(face_end_) : free_.back();
    faces_[index] = {};
    faces_[index].vertex = vertex;
    FACET_TRY(refresh(index));
    if (free_.empty()) {
        ++face_end_;
    } else {
        free_.pop_back();
    }
    alive_[index] = true;
    buckets_[bucket] = index;
    ++face_count_;
    for (std::size_t k = 0; k < 3; ++k) {
        link(static_cast<Corner>(3 * index + k), vertex[k]);
    }
    return index;
}

void HorizonMesh::link(Corner corner, VertexSlot vertex) {
    Corner& first = first_corner_[vertex];
    next_corner_[corner] = first;
    previous_corner_[corner] = kNoCorner;
    if (first != kNoCorner) {
        previous_corner_[first] = corner;
    }
    first = corner;
    ++face_count_of_[vertex];
}

void HorizonMesh::unlink(Corner corner, VertexSlot vertex) {
    const Corner next = next_corner_[corner];
    const Corner previous = previous_corner_[corner];
    (previous == kNoCorner ? first_corner_[vertex] : next_corner_[previous]) = next;
    if (next != kNoCorner) {
        previous_corner_[next] = previous;
    }
    --face_count_of_[vertex];
}

void HorizonMesh::turn(FaceIndex index) {
    FACET_ASSERT(is_face(index));
    MeshFace& face = faces_[index];
    for (std::size_t k = 1; k < 3; ++k) {
        unlink(static_cast<Corner>(3 * index + k), face.vertex[k]);
    }
    std::swap(face.vertex[1], face.vertex[2]);
    for (std::size_t k = 1; k < 3; ++k) {
        link(static_cast<Corner>(3 * index + k), face.vertex[k]);
    }
    face.normal_W = -face.normal_W;
}

/// Empties a bucket and moves back every later entry of the run whose home does not lie behind the hole.
void HorizonMesh::unhash(std::uint32_t hole) {
    for (std::uint32_t b = (hole + 1) % kBuckets; buckets_[b] != kNoFace; b = (b + 1) % kBuckets) {
        const std::uint32_t reach = (b - home(key_of(faces_[buckets_[b]].vertex))) % kBuckets;
        if (reach >= (b - hole) % kBuckets) {
            buckets_[hole] = buckets_[b];
            hole = b;
        }
    }
    buckets_[hole] = kNoFace;
}

void HorizonMesh::remove_face(FaceIndex index) {
    FACET_ASSERT(is_face(index));
    unhash(find_bucket(key_of(faces_[index].vertex)));
    for (std::size_t k = 0; k < 3; ++k) {
        unlink(static_cast<Corner>(3 * index + k), faces_[index].vertex[k]);
    }
    alive_[index] = false;
    free_.push_back(index);
    --face_count_;
}

Status HorizonMesh::refresh(FaceIndex index) {
    MeshFace& face = faces_[index];
    const Eigen::Vector3d a = corner(face, 0);
    const Eigen::Vector3d cross = (corner(face, 1) - a).cross(corner(face, 2) - a);
    const double norm = cross.norm();
    if (!(norm > 2.0 * kMinArea)) {
        return Status::kDegenerate;
    }
    face.area_m2 = static_cast<float>(0.5 * norm);
    face.normal_W = (cross / norm).cast<float>();
    float variance = 0.0F;
    for (const VertexSlot v : face.vertex) {
        variance += std::max(0.0F, face.normal_W.dot(vertices_[v].covariance_W * face.normal_W));
    }
    face.sigma_m = std::sqrt(variance / 3.0F);
    return Status::kOk;
}

}  // namespace facet
