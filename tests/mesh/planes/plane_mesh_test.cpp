// SPDX-License-Identifier: BSD-2-Clause
// What the mesh learns from the planes found in it.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "mesh/planes/plane_finder.h"
#include "tests/mesh/planes/plane_worlds.h"

namespace facet::plane_mesh_test {
namespace {

using Eigen::Vector3d;
using test::Corner;
using test::find_like;
using test::kCorner;
using test::PlaneRig;

TEST_CASE("faces carry the plane they lie on") {
    const Corner world;
    PlaneRig rig(world);
    const PlaneProposals& proposals = rig.hover(kCorner, 4);
    REQUIRE(proposals.size() == 3);
    const HorizonMesh& mesh = rig.mesher->mesh();
    double labelled = 0.0;
    double total = 0.0;
    double wrong = 0.0;
    for (int i = 0; i < mesh.face_end(); ++i) {
        if (!mesh.is_face(i)) {
            continue;
        }
        const MeshFace& face = mesh.face(static_cast<FaceIndex>(i));
        const auto area = static_cast<double>(face.area_m2);
        total += area;
        const auto at = std::find_if(proposals.begin(), proposals.end(),
                                     [&](const PlaneProposal& p) { return p.id == face.plane; });
        if (at != proposals.end()) {
            labelled += area;
            wrong += std::abs(at->normal_W.dot(mesh.centroid(face)) - at->distance_m) > 0.06 ? area : 0.0;
        }
    }
    CHECK(labelled > 0.6 * total);  // the rest spans corners, or has an uncertain corner
    CHECK(wrong < 0.01 * total);
}

TEST_CASE("surface points bear faces of a plane, but only landmarks make one") {
    const Corner world;
    PlaneRig rig(world);
    rig.viewer.is_landmark = [](std::size_t i) { return i % 3 != 0; };
    const PlaneProposals& proposals = rig.hover(kCorner, 4);
    REQUIRE(proposals.size() == 3);
    for (const PlaneProposal& p : proposals) {
        for (const LandmarkId id : p.landmarks) {
            REQUIRE(id.value < test::WorldViewer::kSurfaceIds);
        }
    }
    const HorizonMesh& mesh = rig.mesher->mesh();
    int labelled = 0;
    int faces = 0;
    for (int i = 0; i < mesh.face_end(); ++i) {
        if (!mesh.is_face(i)) {
            continue;
        }
        const MeshFace& face = mesh.face(static_cast<FaceIndex>(i));
        const bool has_surface_point = std::any_of(face.vertex.begin(), face.vertex.end(),
                                                   [&](VertexSlot v) { return mesh.vertex(v).is_surface_point; });
        faces += has_surface_point ? 1 : 0;
        labelled += has_surface_point && face.plane.valid() ? 1 : 0;
    }
    REQUIRE(faces > 100);
    CHECK(labelled > 0.6 * faces);
    // The same walls with hardly a landmark: as many faces, and no plane.
    PlaneRig sparse(world);
    sparse.viewer.is_landmark = [](std::size_t i) { return i % 40 == 0; };
    CHECK(sparse.hover(kCorner, 4).empty());
    CHECK(sparse.mesher->mesh().face_count() > 100);
}

TEST_CASE("vertices are drawn to a plane that the estimator holds, and let go with it") {
    const Corner world;
    PlaneRig rig(world);
    rig.viewer.is_landmark = [](std::size_t i) { return i % 3 != 0; };
    const PlaneProposals& proposals = rig.hover(kCorner, 4);
    const HorizonMesh& mesh = rig.mesher->mesh();
    const PlaneProposal* floor = find_like(proposals, Vector3d::UnitZ());
    REQUIRE(floor != nullptr);
    const PlaneProposal told = *floor;
    /// Root mean square height of the vertices of the floor's faces; of the surface points among them, too.
    const auto rms = [&](bool surface) {
        double sum = 0.0;
        int count = 0;
        for (int i = 0; i < mesh.face_end(); ++i) {
            const MeshFace& face = mesh.face(static_cast<FaceIndex>(i));
            for (std::size_t k = 0; mesh.is_face(i) && face.plane == told.id && k < 3; ++k) {
                const MeshVertex& vertex = mesh.vertex(face.vertex[k]);
                if (!surface || vertex.is_surface_point) {
                    sum += std::pow(told.normal_W.dot(vertex.shown_W()) - told.distance_m, 2);
                    ++count;
                }
            }
        }
        REQUIRE(count > 50);
        return std::sqrt(sum / count);
    };
    const double free = rms(false);
    const double free_surface = rms(true);
    PlaneEstimate estimate{told.id, told.kind, told.normal_W, told.distance_m, 50};
    const auto step = [&](bool is_held) {
        rig.viewer.view(++rig.number, kCorner);
        rig.viewer.last().planes.clear();
        if (is_held) {
            rig.viewer.last().planes.push_back(estimate);
        }
        rig.step_on(rig.viewer.last());
    };
    step(true);
    CHECK(rms(false) < 0.75 * free);
    CHECK(rms(true) < 0.75 * free_surface);
    const double once = rms(false);
    for (int k = 0; k < 5; ++k) {
        step(true);  // from where they were measured each time: not nearer and nearer
    }
    CHECK(rms(false) == Approx(once).epsilon(0.15));
    int drawn = 0;
    for (const LandmarkSnapshot& s : rig.viewer.last().landmarks) {
        if (const auto slot = mesh.find_vertex(s.id); slot.ok()) {
            const MeshVertex& vertex = mesh.vertex(slot.value());
            REQUIRE(vertex.measured_W == s.p_W);  // the correction is kept apart, so nothing adds up in it
            drawn += vertex.shown_W() != s.p_W ? 1 : 0;
        }
    }
    CHECK(drawn > 20);
    step(false);
    for (int i = 0; i < mesh.vertex_end(); ++i) {
        REQUIRE((!mesh.is_vertex(i) || mesh.vertex(static_cast<VertexSlot>(i)).to_plane_W.isZero()));
    }
    CHECK(rms(false) == Approx(free).epsilon(0.15));
}

}  // namespace
}  // namespace facet::plane_mesh_test
