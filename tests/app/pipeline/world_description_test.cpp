// SPDX-License-Identifier: BSD-2-Clause
#include "app/pipeline/world_description.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>

#include "tests/mesh/mesh_world.h"

namespace facet::world_description_test {
namespace {

TEST_CASE("a face and its vertices are described as shown; what has left is gone") {
    const auto mesh = std::make_unique<HorizonMesh>();
    std::array<VertexSlot, 3> slots{};
    for (std::uint32_t i = 0; i < 3; ++i) {
        slots[i] = mesh->add_vertex(LandmarkId{i}).value();
        mesh->vertex(slots[i]).measured_W = {i == 1 ? 1.0 : 0.0, i == 2 ? 1.0 : 0.0, 2.0};
        mesh->vertex(slots[i]).to_plane_W = {0.0, 0.0, 0.25};
    }
    const FaceIndex f = mesh->add_face(slots).value();
    WorldState world;
    world.planes.resize(3);
    describe_world(*mesh, {}, nullptr, world);
    CHECK(world.planes.empty());
    CHECK(world.cell_m == 0.0);
    REQUIRE(world.faces[f].is_used);
    CHECK(world.faces[f].vertex == mesh->face(f).vertex);
    CHECK(world.faces[f].plane == kNoWorldPlane);
    CHECK(world.vertices_W[slots[1]] == std::array<float, 3>{1.0F, 0.0F, 2.25F});
    mesh->remove_face(f);
    describe_world(*mesh, {}, nullptr, world);
    CHECK(std::none_of(world.faces.begin(), world.faces.end(), [](const WorldFace& face) { return face.is_used; }));
}

TEST_CASE("the described grid answers as the grid itself, also when it has rolled") {
    const auto grid = std::make_unique<OccupancyGrid>();
    const auto mesher = test::make_mesher();
    REQUIRE(ok(grid->configure({})));
    WorldState world;
    std::array<int, 3> seen{};
    int is_older = 0;
    int is_aged = 0;
    for (int k = 0; k < 6; ++k) {
        const Eigen::Vector3d p_W(-3.0 + 1.7 * k, 0.4 * k, 0.03);
        test::MeshWorld wall;
        wall.wall(1.6, 1.0, 0.25, [&](double, double) { return p_W.x() + 3.05; });
        const auto view = test::view_of(wall, test::looking_along_x(p_W), k);
        view->stamp = Timestamp{} + Duration::from_seconds(10.0 + 0.25 * k);
        view->oldest_stamp = {0};
        mesher->update(*view, {});
        grid->update(*view, mesher->mesh(), static_cast<std::uint32_t>(mesher->counters().updates));
        describe_world(mesher->mesh(), {}, grid.get(), world);
        for (double x = -8.0; x < 8.0; x += 0.1) {
            for (double y = -7.0; y < 7.0; y += 0.23) {
                for (double z = -4.0; z < 4.0; z += 0.31) {
                    const Eigen::Vector3d q = p_W + Eigen::Vector3d(x, y, z);
                    const Space space = grid->at(q).space;
                    const WorldSpace expected = space == Space::kFree       ? WorldSpace::kFree
                                                : space == Space::kOccupied ? WorldSpace::kOccupied
                                                                            : WorldSpace::kUnknown;
                    const WorldPoint point = world.describe({q.x(), q.y(), q.z()});
                    const GridState state = grid->at(q);
                    // Levels end below the greatest certainty, and a run of cells has the age of its oldest.
                    const float above = state.certainty - point.certainty;
                    if (world.at({q.x(), q.y(), q.z()}) != expected || point.space != expected || above < -1e-3F ||
                        above > 0.025F || point.age_s < state.age_s - 1e-3F) {
                        FAIL(q.transpose());
                    }
                    is_older += point.age_s > state.age_s + 1e-3F ? 1 : 0;
                    is_aged += point.age_s > 0.0F ? 1 : 0;
                    ++seen[static_cast<std::size_t>(space)];
                }
            }
        }
    }
    CHECK(seen[0] > 100);
    CHECK(seen[1] > 100);
    CHECK(seen[2] > 10);
    CHECK(is_aged > 100);
    CHECK(5 * is_older < seen[0] + seen[2]);
}

}  // namespace
}  // namespace facet::world_description_test
