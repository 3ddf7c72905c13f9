// SPDX-License-Identifier: BSD-2-Clause
// planes.json in both forms, from both writers, and with every mistake.
#include "app/lab/eval/plane_file.h"

#include <catch2/catch.hpp>

#include "app/output/plane_log.h"
#include "tests/support/input_error_text.h"
#include "tests/support/temp_dir.h"

namespace facet::plane_file_test {
namespace {

using Eigen::Vector3d;

std::vector<EvalPlane> load_text(const std::string& text) {
    const test::TempDir folder;
    folder.write("planes.json", text);
    return load_planes(folder.file("planes.json"));
}

TEST_CASE("planes are read in the order of the file, with what it says about them") {
    const std::vector<EvalPlane> planes = load_text(R"([
        {"id": 0, "normal": [-1, 0, 0], "distance": -3, "kind": "vertical", "name": "wall"},
        {"id": 7, "normal": [0, 0, 1], "distance": 0.25, "seen_area": 7.5, "inliers": 20},
        {"normal": [0, 0.6, 0.8], "distance": 1.5}])");
    REQUIRE(planes.size() == 3);
    CHECK(planes[0].name == "wall");
    CHECK(planes[0].normal == Vector3d(-1.0, 0.0, 0.0));
    CHECK(planes[0].distance == -3.0);
    CHECK(planes[0].seen_m2 == 0.0);
    CHECK(planes[1].name == "plane 7");
    CHECK(planes[1].distance == 0.25);
    CHECK(planes[1].seen_m2 == 7.5);
    CHECK(planes[2].name.empty());
    CHECK(planes[2].normal == Vector3d(0.0, 0.6, 0.8));
    CHECK(planes[2].box.contains(Vector3d(1e6, -1e6, 0.0)));
    const auto boxed = load_text(R"([{"normal": [1, 0, 0], "distance": 1, "min": [1, -2, 0], "max": [1, 2, 3]}])");
    CHECK(boxed.front().box.contains(Vector3d(1.0, 1.5, 3.0)));
    CHECK_FALSE(boxed.front().box.contains(Vector3d(1.0, 2.5, 3.0)));
    CHECK(load_text("[]").empty());
}

TEST_CASE("the older form of true planes is read as before") {
    const std::vector<EvalPlane> planes = load_text(R"({
        "frame": "world", "convention": "normal . x = offset; the normal points into free space",
        "planes": [{"id": 0, "name": "ceiling", "normal": [0, 0, -1], "offset": -3.55, "seen_area": 48.8},
                   {"normal": [1, 0, 0], "offset": 2}]})");
    REQUIRE(planes.size() == 2);
    CHECK(planes[0].name == "ceiling");
    CHECK(planes[0].distance == -3.55);
    CHECK(planes[0].seen_m2 == 48.8);
    CHECK(planes[1].name.empty());
    CHECK(planes[1].distance == 2.0);
}

TEST_CASE("the planes that a run writes can be read") {
    const test::TempDir folder;
    PlaneLog log(folder.path());
    TrackedPlane plane;
    plane.id = PlaneId{3};
    plane.kind = PlaneKind::kVertical;
    plane.is_reported = true;
    plane.fit.normal_W = Vector3d(0.6, -0.8, 0.0);
    plane.fit.distance_m = -1.0 / 3.0;
    log.write(Timestamp{1}, {&plane, 1}, {&plane.fit, 1});
    log.write_planes(folder.path(), {});
    const std::vector<EvalPlane> planes = load_planes(folder.file("planes.json"));
    REQUIRE(planes.size() == 1);
    CHECK(planes[0].name == "plane 3");
    CHECK(planes[0].normal == plane.fit.normal_W);
    CHECK(planes[0].distance == plane.fit.distance_m);
}

TEST_CASE("without a file there are no planes") {
    const test::TempDir folder;
    CHECK(load_planes(folder.file("planes.json")).empty());
}

TEST_CASE("what cannot be used is reported with file and entry") {
    const auto message = [](const std::string& text) { return test::input_error_text([&] { load_text(text); }); };
    const std::string good = R"({"normal": [1, 0, 0], "distance": 1}, )";
    const auto second = [&](const std::string& entry) { return message("[" + good + entry + "]"); };
    using Catch::Contains;
    CHECK_THAT(message("[{"), Contains("planes.json: ") && Contains("parse error"));
    CHECK_THAT(message("7"), Contains("planes.json: not an array of planes"));
    CHECK_THAT(message(R"({"normal": [1, 0, 0]})"), Contains("not an array of planes"));
    CHECK_THAT(message(R"({"planes": {}})"), Contains("not an array of planes"));
    CHECK_THAT(message(R"({"planes": [{"normal": [1, 0, 0], "distance": 1}]})"),
               Contains(R"(entry 0 has no number "offset")"));
    CHECK_THAT(second("[1, 0, 0]"), Contains("planes.json: entry 1 is not an object"));
    CHECK_THAT(second(R"({"normal": [1, 0, 0]})"), Contains(R"(entry 1 has no number "distance")"));
    CHECK_THAT(second(R"({"normal": [1, 0, 0], "offset": 1})"), Contains(R"(entry 1 has no number "distance")"));
    CHECK_THAT(second(R"({"normal": [1, 0, 0], "distance": "1"})"), Contains(R"(entry 1 has no number "distance")"));
    CHECK_THAT(second(R"({"distance": 1})"), Contains(R"(entry 1 has no "normal" of three numbers)"));
    CHECK_THAT(second(R"({"normal": [1, 0], "distance": 1})"), Contains(R"(entry 1 has no "normal" of three numbers)"));
    CHECK_THAT(second(R"({"normal": [1, 0, null], "distance": 1})"),
               Contains(R"(entry 1 has no "normal" of three numbers)"));
    CHECK_THAT(second(R"({"normal": [0, 0, 2], "distance": 1})"),
               Contains(R"(entry 1 has a "normal" that is not a unit vector)"));
    CHECK_THAT(second(R"({"normal": [1, 0, 0], "distance": 1, "seen_area": []})"),
               Contains(R"(entry 1 has no number "seen_area")"));
    CHECK_THAT(second(R"({"normal": [1, 0, 0], "distance": 1, "name": 5})"),
               Contains("entry 1 has a name that is not text"));
    CHECK_THAT(second(R"({"normal": [1, 0, 0], "distance": 1, "id": -1})"),
               Contains("entry 1 has an id that is not a natural number"));
}

}  // namespace
}  // namespace facet::plane_file_test
