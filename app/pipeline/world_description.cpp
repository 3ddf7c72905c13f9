// SPDX-License-Identifier: BSD-2-Clause
#include "app/pipeline/world_description.h"

#include <algorithm>

namespace facet {
namespace {

static_assert(kMaxMeshVertices == kWorldVertices && kMaxMeshFaces == kWorldFaces);
static_assert(OccupancyGrid::kGridX == kWorldCells[0] && OccupancyGrid::kGridY == kWorldCells[1] &&
              OccupancyGrid::kGridZ == kWorldCells[2] && OccupancyGrid::kPackedBytes == kWorldGridBytes &&
              OccupancyGrid::kRun == kWorldRun && OccupancyGrid::kTicks == kWorldTicks);

std::array<float, 3> to_floats(const Eigen::Vector3d& v) {
    return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

}  // namespace

void describe_world(const HorizonMesh& mesh, std::span<const TrackedPlane> planes, const OccupancyGrid* grid,
                    WorldState& world) {
    world.planes.clear();
    for (const TrackedPlane& plane : planes.first(std::min<std::size_t>(planes.size(), kWorldPlanes))) {
        world.planes.push_back(
            {plane.id.value, to_floats(plane.fit.normal_W), static_cast<float>(plane.fit.distance_m)});
    }
    for (int v = 0; v < kWorldVertices; ++v) {
        world.vertices_W[static_cast<std::size_t>(v)] =
            mesh.is_vertex(v) ? to_floats(mesh.vertex(static_cast<VertexSlot>(v)).shown_W()) : std::array<float, 3>{};
    }
    for (int f = 0; f < kWorldFaces; ++f) {
        WorldFace& to = world.faces[static_cast<std::size_t>(f)];
        to = {};
        if (mesh.is_face(f)) {
            const MeshFace& face = mesh.face(static_cast<FaceIndex>(f));
            to = {face.vertex, face.observations, face.plane.value, face.sigma_m, true, face.is_fill};
        }
    }
    world.cell_m = grid == nullptr ? 0.0 : grid->cell_m();
    world.low = {};
    world.tick = 0;
    if (grid == nullptr) {
        std::fill(world.cells.begin(), world.cells.end(), std::uint8_t{0});
        std::fill(world.levels.begin(), world.levels.end(), std::uint8_t{0});
        std::fill(world.confirmed.begin(), world.confirmed.end(), std::uint16_t{0});
        return;
    }
    const Eigen::Vector3i low = grid->lowest_cell();
    world.low = {low.x(), low.y(), low.z()};
    world.tick = grid->tick();
    grid->pack(std::span<std::uint8_t, OccupancyGrid::kPackedBytes>(world.cells));
    grid->pack_belief(std::span<std::uint8_t, OccupancyGrid::kPackedBytes>(world.levels),
                      std::span<std::uint16_t, OccupancyGrid::kRuns>(world.confirmed));
}

}  // namespace facet
