// SPDX-License-Identifier: BSD-2-Clause
// The mesh of a whole run, and its files.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <memory_resource>
#include <span>
#include <string>
#include <vector>

#include "app/output/plane_names.h"
#include "mesh/mesher.h"

namespace facet {

/// Collects faces as they leave the horizon and writes meshes as PLY with vertex normals and plane ids. A face is
/// identified by its three landmarks: if it comes back, the newer one replaces the older one. Faces share a vertex if
/// they have the same landmark at the same place. When full: new faces are dropped and counted; faces already there can
/// still be replaced. Heap: now and then, more each time, not at every face. Thread-bound; stays where it is made.
class RunMesh {
public:
    explicit RunMesh(std::size_t max_faces = std::numeric_limits<std::size_t>::max()) : max_faces_(max_faces) {}

    /// Takes the faces that left in the mesher's last update.
    void collect(const Mesher& mesher) { collect(mesher.departed()); }
    void collect(std::span<const DepartedFace> departed);

    /// Writes folder/mesh_live.ply (the horizon) and folder/mesh_horizon.ply (everything, the horizon included). Throws
    /// InputError if it cannot.
    /// @param names  the ids that planes have by now
    void write(const Mesher& mesher, const std::string& folder, const PlaneNames& names = {});
    /// Writes everything that was collected or written before. Throws InputError if it cannot.
    void write_all(const std::string& path, const PlaneNames& names = {}) const;

    /// What write_all() writes: each face as it stood last.
    std::span<const DepartedFace> all() const { return faces_; }
    std::size_t faces() const { return faces_.size(); }
    std::size_t dropped() const { return dropped_; }

private:
    void add(const DepartedFace& face);

    std::size_t max_faces_;
    std::size_t dropped_ = 0;
    std::vector<DepartedFace> faces_;
    std::pmr::monotonic_buffer_resource nodes_;  ///< of the map, from which nothing is ever taken
    std::pmr::map<std::array<std::uint32_t, 3>, std::size_t> by_landmarks_{&nodes_};  ///< sorted ids -> index in faces_
};

}  // namespace facet
