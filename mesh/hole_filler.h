// SPDX-License-Identifier: BSD-2-Clause
// Closes the holes that leaving landmarks leave in surfaces.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

#include "mesh/horizon_mesh.h"

namespace facet {

/// Remembers the rings of neighbours around vertices that are about to leave, alone or several next to each other, then
/// triangulates those that still bound a hole. A ring is filled if all its vertices are still there, none of its sides
/// has gained a second face, and it lies within kHolePlanarity_m of a plane (through its centroid, with Newell's
/// normal), or within twice that if all faces that left were of one plane. Ears are cut in order of their smallest
/// angle, largest first. At most kMaxHoles rings are filled in an update; the others stay open. Thread-bound. No heap.
class HoleFiller {
public:
    void clear() { holes_.clear(); }

    /// Remembers the rings around vertices whose faces are about to leave. Vertices of common faces leave one hole; it
    /// is left open if its border is no single closed line.
    /// @param leaving  by increasing slot
    void remember(const HorizonMesh& mesh, std::span<const VertexSlot> leaving);

    struct Filled {
        int holes = 0;
        int faces = 0;
    };
    /// Fills the rings that still bound a hole, then forgets all rings.
    /// @param update  number of the current update, for the new faces
    Filled fill(double max_side_m, std::uint32_t update, HorizonMesh& mesh);

private:
    static constexpr std::size_t kMaxRing = 24;
    static constexpr std::size_t kMaxHoles = 64;
    struct Hole {
        FixedVector<VertexSlot, kMaxRing> ring;     ///< counterclockwise around the normal
        std::array<LandmarkId, kMaxRing> landmark;  ///< of the ring: slots may be used again
        std::uint16_t observations = 0;             ///< fewest of any face that left
        PlaneId plane;                              ///< of all of them, or invalid
    };
    using Sides = FixedVector<std::array<VertexSlot, 2>, kMaxRing>;

    bool collect_group(const HorizonMesh& mesh, VertexSlot first, Sides& sides, Hole& hole);
    static bool close_ring(const HorizonMesh& mesh, const Sides& sides, Hole& hole);
    static bool is_open(const HorizonMesh& mesh, const Hole& hole);
    static bool flatten(const HorizonMesh& mesh, const Hole& hole, std::array<Eigen::Vector2d, kMaxRing>& flat);
    static int triangulate(double max_side_m, std::uint32_t update, const Hole& hole,
                           const std::array<Eigen::Vector2d, kMaxRing>& flat, HorizonMesh& mesh);

    FixedVector<Hole, kMaxHoles> holes_;
    // Scratch of remember():
    enum class Leaving : std::uint8_t { kNo, kYes, kTaken };
    std::array<Leaving, kMaxMeshVertices> state_{};
    FixedVector<VertexSlot, kMaxMeshVertices> group_;  ///< leaving vertices that common faces connect
};

}  // namespace facet
