// SPDX-License-Identifier: BSD-2-Clause
// The files of a run's mesh: every face once, as it stood last.
#include "app/output/run_mesh.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <map>
#include <memory>
#include <set>

#include "app/support/ply_reader.h"
#include "tests/mesh/keyframe_samples.h"
#include "tests/support/temp_dir.h"

namespace facet::run_mesh_test {
namespace {

using Corners = std::array<std::array<float, 3>, 3>;

Corners sorted_corners(const std::array<Eigen::Vector3f, 3>& p) {
    Corners c{{{p[0].x(), p[0].y(), p[0].z()}, {p[1].x(), p[1].y(), p[1].z()}, {p[2].x(), p[2].y(), p[2].z()}}};
    std::sort(c.begin(), c.end());
    return c;
}

std::multiset<Corners> corners_in(const std::string& path) {
    PlyTriangles read;
    std::string error;
    INFO(error);
    REQUIRE(ok(read_ply(path, read, error)));
    std::multiset<Corners> set;
    for (const Eigen::Vector3i& t : read.triangles) {
        std::array<Eigen::Vector3f, 3> p;
        for (std::size_t k = 0; k < 3; ++k) {
            p[k] = read.vertices[static_cast<std::size_t>(t[static_cast<int>(k)])].cast<float>();
        }
        set.insert(sorted_corners(p));
    }
    return set;
}

TEST_CASE(
    "mesh_horizon.ply has every face that left as it stood then, and the live ones; mesh_live.ply the live ones") {
    const auto mesher = std::make_unique<Mesher>();
    REQUIRE(ok(mesher->configure({}, test::mesh_camera())));
    const test::WallFlight flight;
    RunMesh run;
    std::map<std::set<std::uint32_t>, Corners> expected;
    const auto note = [&](const DepartedFace& f) {
        expected[{f.landmark[0].value, f.landmark[1].value, f.landmark[2].value}] = sorted_corners(f.p_W);
    };
    for (int k = 0; k < 40; ++k) {
        const auto view = flight.view(k);
        for (LandmarkSnapshot& s : view->landmarks) {
            s.p_W.z() += 0.001 * k;  // estimates move: how a face stood last matters
        }
        mesher->update(*view, {});
        run.collect(*mesher);
        for (const DepartedFace& face : mesher->departed()) {
            note(face);
        }
    }
    const HorizonMesh& mesh = mesher->mesh();
    std::multiset<Corners> live;
    for (int i = 0; i < mesh.face_end(); ++i) {
        if (mesh.is_face(i)) {
            const MeshFace& face = mesh.face(static_cast<FaceIndex>(i));
            live.insert(sorted_corners(mesher->describe(face).p_W));
            if (!face.is_fill) {
                note(mesher->describe(face));
            }
        }
    }
    const test::TempDir folder;
    run.write(*mesher, folder.path());
    CHECK(corners_in(folder.file("mesh_live.ply")) == live);
    std::multiset<Corners> all;
    for (const auto& [landmarks, corners] : expected) {
        all.insert(corners);
    }
    REQUIRE(all.size() > live.size() + 100);
    CHECK(run.faces() == all.size());
    CHECK(corners_in(folder.file("mesh_horizon.ply")) == all);
    run.write_all(folder.file("mesh.ply"));
    CHECK(corners_in(folder.file("mesh.ply")) == all);
}

TEST_CASE("a mesh without faces is a file without faces, and a folder that is not there is named") {
    const auto mesher = std::make_unique<Mesher>();
    REQUIRE(ok(mesher->configure({}, test::mesh_camera())));
    const test::TempDir folder;
    RunMesh run;
    run.write(*mesher, folder.path());
    CHECK(corners_in(folder.file("mesh_horizon.ply")).empty());
    CHECK_THROWS(run.write(*mesher, folder.file("no/such/folder")));
}

}  // namespace
}  // namespace facet::run_mesh_test
