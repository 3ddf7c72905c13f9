// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/horizon_mesh.h"

#include <catch2/catch.hpp>
#include <map>
#include <set>

#include "tests/mesh/mesh_samples.h"

namespace facet::horizon_mesh_test {
namespace {

using Key = std::set<VertexSlot>;

TEST_CASE("faces are found by their vertices in any order, and only once") {
    HorizonMesh mesh;
    const VertexSlot a = test::add_vertex(mesh, 7, {0.0, 0.0, 0.0});
    const VertexSlot b = test::add_vertex(mesh, 8, {3.0, 0.0, 0.0});
    const VertexSlot c = test::add_vertex(mesh, 9, {0.0, 4.0, 0.0});
    const VertexSlot d = test::add_vertex(mesh, 10, {6.0, 0.0, 0.0});
    const auto face = mesh.add_face({a, b, c});
    REQUIRE(face.ok());
    CHECK(mesh.find_face({c, a, b}) == face.value());
    CHECK(mesh.find_face({b, a, c}) == face.value());
    CHECK(mesh.find_face({b, a, d}) == HorizonMesh::kNoFace);
    CHECK(mesh.add_face({c, b, a}).status() == Status::kInvalidArgument);
    CHECK(mesh.add_face({a, b, a}).status() == Status::kInvalidArgument);
    CHECK(mesh.add_face({a, b, d}).status() == Status::kDegenerate);  // on one line
    CHECK(mesh.face_count() == 1);
    CHECK(mesh.face(face.value()).area_m2 == Approx(6.0F));
    CHECK(mesh.face(face.value()).normal_W.z() == Approx(1.0F));
    CHECK(mesh.face(face.value()).sigma_m == Approx(0.01F));
    mesh.remove_face(face.value());
    mesh.remove_vertex(a);
    CHECK_FALSE(mesh.find_vertex({7}).ok());
    CHECK(mesh.faces_at(b) == 0);
}

TEST_CASE("a long random history agrees with a map of faces") {
    HorizonMesh mesh;
    std::mt19937 random(4);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    std::map<Key, FaceIndex> model;
    std::vector<VertexSlot> slots;
    for (std::uint32_t id = 0; id < 40; ++id) {
        const double x = uniform(random);
        const double y = uniform(random);
        slots.push_back(test::add_vertex(mesh, id, {x, y, uniform(random)}));
    }
    for (int step = 0; step < 60000; ++step) {
        const auto pick = [&] { return slots[random() % slots.size()]; };
        const std::array<VertexSlot, 3> v{pick(), pick(), pick()};
        const Key key(v.begin(), v.end());
        if (key.size() < 3) {
            continue;
        }
        const auto at = model.find(key);
        REQUIRE(mesh.find_face(v) == (at == model.end() ? HorizonMesh::kNoFace : at->second));
        if (at != model.end()) {
            mesh.remove_face(at->second);
            model.erase(at);
        } else if (random() % 3 != 0) {
            const auto added = mesh.add_face(v);
            REQUIRE(added.ok());
            model[key] = added.value();
        }
        if (step % 500 == 0) {
            REQUIRE(mesh.face_count() == static_cast<int>(model.size()));
            std::map<VertexSlot, int> degree;
            for (const auto& [k, f] : model) {
                for (const VertexSlot s : k) {
                    ++degree[s];
                }
            }
            for (const VertexSlot s : slots) {
                int seen = 0;
                mesh.for_faces_of(s, [&](FaceIndex f) {
                    const auto& w = mesh.face(f).vertex;
                    seen += model.at(Key(w.begin(), w.end())) == f ? 1 : 1000;
                });
                REQUIRE(seen == degree[s]);
                REQUIRE(mesh.faces_at(s) == seen);
            }
        }
    }
}

TEST_CASE("a full mesh refuses faces and takes them again after a removal") {
    const auto mesh = test::random_mesh(kMaxMeshFaces, 5);
    REQUIRE(mesh->full());
    const VertexSlot a = mesh->face(0).vertex[0];
    const VertexSlot far = mesh->face(kMaxMeshFaces - 1).vertex[0];
    const VertexSlot b = mesh->face(0).vertex[1];
    CHECK(mesh->add_face({a, b, far}).status() == Status::kFull);
    mesh->remove_face(17);
    const auto added = mesh->add_face({a, b, far});
    REQUIRE(added.ok());
    CHECK(added.value() == 17);
    CHECK(mesh->face_end() == kMaxMeshFaces);
}

}  // namespace
}  // namespace facet::horizon_mesh_test
