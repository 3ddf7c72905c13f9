// SPDX-License-Identifier: BSD-2-Clause
#include "app/output/run_surface.h"

#include <catch2/catch.hpp>
#include <memory>

#include "app/support/ply_reader.h"
#include "tests/support/temp_dir.h"

namespace facet::run_surface_test {
namespace {

/// A square of 32 cm at z = 0 that a block has: one quad from corner to corner. `at` is in blocks.
std::unique_ptr<SurfacePiece> square_at(int x, float grey = 50.0F) {
    auto piece = std::make_unique<SurfacePiece>();
    piece->at = {x, 0, 0};
    for (int k = 0; k < 4; ++k) {
        const int right = k == 1 || k == 2 ? 7 : -1;
        const int up = k >= 2 ? 7 : -1;
        SurfaceVertex v;
        v.p_W = 0.04F * Eigen::Vector3f(static_cast<float>(8 * x + right), static_cast<float>(up), 0.0F);
        v.normal_W = Eigen::Vector3f::UnitZ();
        v.grey = grey;
        v.cell = {static_cast<std::int8_t>(right), static_cast<std::int8_t>(up), 0};
        piece->vertices.push_back(v);
    }
    piece->triangles.push_back({{0, 1, 2}, 3, 0.01F});
    piece->triangles.push_back({{0, 2, 3}, 3, 0.01F});
    return piece;
}

DepartedFace face_on(PlaneId plane, float z) {
    DepartedFace face;
    face.plane = plane;
    face.p_W = {Eigen::Vector3f(-1.0F, -1.0F, z), Eigen::Vector3f(3.0F, -1.0F, z), Eigen::Vector3f(-1.0F, 3.0F, z)};
    return face;
}

TEST_CASE("pieces that meet are joined, the newest of a block counts, and one without surface does not") {
    RunSurface surface;
    surface.take(*square_at(0), 0);
    surface.take(*square_at(1), 0);
    SurfaceMesh mesh = surface.mesh();
    CHECK(mesh.vertices.size() == 6);
    CHECK(mesh.triangles.size() == 4);
    surface.take(*square_at(1, 90.0F), 0);
    CHECK(surface.triangles() == 4);
    CHECK(surface.mesh().greys.back() == 90);
    surface.take(*square_at(1), 1);  // after a restart: another surface
    CHECK(surface.mesh().vertices.size() == 10);
    const auto nothing = std::make_unique<SurfacePiece>();
    nothing->at = {1, 0, 0};
    surface.take(*nothing, 0);
    CHECK(surface.triangles() == 4);
}

TEST_CASE("crumbs are left out, and what there is no room for is counted") {
    RunSurface surface(2);
    surface.take(*square_at(0), 0);
    surface.take(*square_at(5), 0);
    CHECK(surface.dropped() == 1);
    CHECK(surface.mesh(0.05).triangles.size() == 2);
    CHECK(surface.mesh(0.2).triangles.empty());
    CHECK(surface.mesh(0.2).vertices.empty());
}

TEST_CASE("triangles have the plane that they lie on and that reaches there") {
    const std::array<DepartedFace, 3> faces{face_on(PlaneId{4}, 0.0F), face_on(PlaneId{7}, 0.02F),
                                            face_on(PlaneId{}, 0.0F)};
    const SurfacePlanes planes(faces, {});
    const Eigen::Vector3f up = Eigen::Vector3f::UnitZ();
    CHECK(planes.plane_of({0.0F, 0.0F, 0.0F}, up) == 4);
    CHECK(planes.plane_of({0.0F, 0.0F, 0.018F}, -up) == 7);
    CHECK(planes.plane_of({0.0F, 0.0F, 0.06F}, up) == -1);
    CHECK(planes.plane_of({0.0F, 0.0F, 0.0F}, Eigen::Vector3f::UnitX()) == -1);
    CHECK(planes.plane_of({2.5F, 2.5F, 0.0F}, up) == -1);  // beyond the faces

    RunSurface surface;
    surface.take(*square_at(0), 0);
    const test::TempDir folder;
    surface.write(folder.file("mesh.ply"), "test", planes);
    PlyTriangles read;
    std::string error;
    REQUIRE(ok(read_ply(folder.file("mesh.ply"), read, error)));
    CHECK(read.triangles.size() == 2);
    CHECK_THROWS(surface.write(folder.file("no/such/mesh.ply"), "test"));
}

}  // namespace
}  // namespace facet::run_surface_test
