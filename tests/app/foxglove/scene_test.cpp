// SPDX-License-Identifier: BSD-2-Clause
#include "app/foxglove/scene.h"

#include <catch2/catch.hpp>
#include <limits>
#include <vector>

#include "app/foxglove/schemas.h"
#include "tests/app/foxglove/schema_check.h"

namespace facet::scene_test {
namespace {

using nlohmann::json;

constexpr Timestamp kStamp{2'000'000'001};

SceneFace face_at(float x, std::int32_t plane) {
    return {{Eigen::Vector3f(x, 0, 0), Eigen::Vector3f(x, 1, 0), Eigen::Vector3f(x, 0, 1)}, plane};
}

json entity_of(const std::string& message) {
    const json scene = json::parse(message);
    CHECK(test::schema_fault(scene, json::parse(schema_text(FoxgloveSchema::kSceneUpdate))).empty());
    REQUIRE(scene["entities"].size() == 1);
    return scene["entities"][0];
}

TEST_CASE("a mesh is one list of triangles a plane, in its colour") {
    SceneFace broken = face_at(9, 3);
    broken.p_W[1].y() = std::numeric_limits<float>::quiet_NaN();
    const std::vector<SceneFace> faces{face_at(1, 3), face_at(2, -1), face_at(3, 3), broken};
    const json mesh = entity_of(mesh_scene(kStamp, "world", faces));
    CHECK(mesh["id"] == "mesh");
    CHECK(mesh["timestamp"] == json{{"sec", 2}, {"nsec", 1}});
    REQUIRE(mesh["triangles"].size() == 2);
    CHECK(mesh["triangles"][0]["points"].size() == 3);
    CHECK(mesh["triangles"][0]["points"][0]["x"] == 2.0);
    CHECK(mesh["triangles"][1]["points"].size() == 6);
    CHECK(mesh["triangles"][1]["points"][4] == json{{"x", 3.0}, {"y", 1.0}, {"z", 0.0}});
    CHECK(mesh["triangles"][1]["color"]["r"].get<float>() == Approx(plane_colour(3)[0]).margin(1e-3));
    CHECK(entity_of(mesh_scene(kStamp, "world", {}))["triangles"].empty());
}

TEST_CASE("a plane is a rectangle with its name") {
    const std::vector<ScenePlane> planes{
        {.id = 7, .kind = PlaneKind::kVertical, .centre_W = {1, 2, 3}, .along_W = {0, 2, 0}, .across_W = {0, 0, 0.5}}};
    const json entity = entity_of(planes_scene(kStamp, "world", planes));
    REQUIRE(entity["triangles"].size() == 1);
    const json& points = entity["triangles"][0]["points"];
    REQUIRE(points.size() == 6);
    CHECK(points[0] == json{{"x", 1.0}, {"y", 0.0}, {"z", 2.5}});
    CHECK(points[2] == json{{"x", 1.0}, {"y", 4.0}, {"z", 3.5}});
    CHECK(points[5] == json{{"x", 1.0}, {"y", 0.0}, {"z", 3.5}});
    CHECK(entity["triangles"][0]["color"]["a"].get<double>() < 0.5);
    REQUIRE(entity["texts"].size() == 1);
    CHECK(entity["texts"][0]["text"] == "vertical 7");
    CHECK(entity["texts"][0]["pose"]["position"] == json{{"x", 1.0}, {"y", 2.0}, {"z", 3.0}});
}

TEST_CASE("planes have colours of their own, also beyond the palette") {
    CHECK(plane_colour(0) != plane_colour(1));
    CHECK(plane_colour(0) != plane_colour(10));
    CHECK(plane_colour(0)[2] == Approx(0xb2 / 255.0));
    CHECK(plane_colour(10)[0] == Approx(0.25));
}

}  // namespace
}  // namespace facet::scene_test
