// SPDX-License-Identifier: BSD-2-Clause
// What the scene "building" is put together from: materials, the shell of a room, and what stands in it.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "app/lab/sim/building_plan.h"
#include "app/lab/sim/scene.h"
#include "app/support/rng.h"

namespace facet::sim {

/// All materials of a building; contrast falls with its richness.
struct BuildingMaterials {
    std::array<MaterialId, 6> walls{};  ///< the first is bare
    std::array<MaterialId, 3> floors{};
    std::array<MaterialId, 3> ceilings{};
    std::array<MaterialId, 3> cartons{};
    std::array<MaterialId, 5> pictures{};
    MaterialId wood = 0, metal = 0, fabric = 0, dark = 0, books = 0, lamp = 0;
};
BuildingMaterials make_building_materials(SceneBuilder& b, double richness, RandomStream& random);

/// One room of the building under construction.
struct RoomSite {
    SceneBuilder& builder;
    const BuildingMaterials& materials;
    const BuildingPlan& building;
    const RoomPlan& room;
    RandomStream& random;
    std::array<std::vector<std::pair<double, double>>, 4> taken{};  ///< stretches of the walls that are not free (m)

    /// World position of a point of the room's frame at a height above the floor there.
    Eigen::Vector3d above_floor(const Eigen::Vector2d& p, double height_m) const;
    /// Reserves a free stretch of a wall. @return its middle along the wall, negative if there is none
    double reserve(int wall, double width_m);
};

/// A flat thing of any orientation: its face, and four sides back to the surface that it lies on.
/// @param origin  corner of the face; u x v points away from the surface
void add_slab(SceneBuilder& b, const std::string& name, MaterialId m, const Eigen::Vector3d& origin,
              const Eigen::Vector3d& u, const Eigen::Vector3d& v, double thickness_m);

/// Floor, walls with doorways, ceiling and lamps. Reserves the doorways.
void add_shell(RoomSite& site);
/// Relief and pictures on the walls, shelves, tables and clutter; the way between the doorways stays free.
void add_furnishing(RoomSite& site);
/// Floor, ceiling and sides of a passage.
void add_passage(SceneBuilder& b, const BuildingMaterials& m, const Passage& passage);

}  // namespace facet::sim
