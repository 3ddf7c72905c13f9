// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/fusion/mesh_fusion.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "app/support/ply_reader.h"
#include "tests/mesh/depth/stereo_scene.h"

namespace facet::mesh_fusion_test {
namespace {

/// Keyframes in front of a surface, all looking along z, with a window of two.
struct Flight {
    test::Surface surface;
    MeshFusion fusion{test::scene_rig()};
    std::unique_ptr<Mesher> mesher = std::make_unique<Mesher>();
    std::unique_ptr<KeyframeView> view = std::make_unique<KeyframeView>();

    explicit Flight(const test::Surface& seen) : surface(seen) {
        REQUIRE(ok(mesher->configure({}, test::scene_rig().left)));
    }

    /// @param error  of the pose that the window has at first; that of the keyframe before becomes right
    void visit(const Eigen::Vector3d& place, const Eigen::Vector3d& error = Eigen::Vector3d::Zero()) {
        const auto left = test::draw(surface, place);
        const auto right = test::draw(surface, place + Eigen::Vector3d(0.1, 0.0, 0.0));
        ++view->number;
        view->stamp = Timestamp{static_cast<std::int64_t>(view->number) * 100'000'000};
        view->T_W_C0.p = place + error;
        while (view->keyframes.size() >= 2) {
            view->keyframes.erase_at(0);
        }
        if (!view->keyframes.empty()) {
            view->keyframes[0].T_W_C0.p = last_;
        }
        view->keyframes.push_back({view->stamp, view->T_W_C0});
        last_ = place;
        fusion.add(*view, 0, left.view(), right.view(), *mesher);
    }
    PlyTriangles written() {
        const auto path = (std::filesystem::temp_directory_path() / "facet_mesh_fusion_test.ply").string();
        fusion.write(path);
        PlyTriangles mesh;
        std::string error;
        REQUIRE(ok(read_ply(path, mesh, error)));
        std::filesystem::remove(path);
        return mesh;
    }

private:
    Eigen::Vector3d last_ = Eigen::Vector3d::Zero();
};

TEST_CASE("a wall flown along is one surface at the poses that the window ends with") {
    Flight flight(test::plane_surface(Eigen::Vector3d::UnitZ(), 2.0));
    const Eigen::Vector3d error(0.0, 0.0, 0.15);
    flight.visit({0.0, 0.0, 0.0}, error);
    flight.visit({0.2, 0.0, 0.0}, error);
    flight.visit({0.4, 0.0, 0.1}, error);
    flight.visit({0.6, 0.0, 0.0});
    const PlyTriangles mesh = flight.written();
    REQUIRE(mesh.triangles.size() > 2000);
    std::vector<double> errors;
    for (const Eigen::Vector3d& v : mesh.vertices) {
        errors.push_back(std::abs(v.z() - 2.0));
    }
    std::sort(errors.begin(), errors.end());
    CHECK(errors[errors.size() / 2] < 0.01);
    CHECK(errors[errors.size() * 9 / 10] < 0.03);
}

TEST_CASE("a board before a wall has its edge, and nothing between the two") {
    Flight flight(test::step_surface(1.2, 2.2));
    flight.visit({-0.2, 0.0, 0.0});
    flight.visit({0.0, 0.05, 0.0});
    flight.visit({0.2, 0.0, 0.0});
    const PlyTriangles mesh = flight.written();
    int between = 0;
    for (const Eigen::Vector3d& v : mesh.vertices) {
        between += v.z() > 1.35 && v.z() < 2.0 ? 1 : 0;
    }
    CHECK(between < static_cast<int>(mesh.vertices.size()) / 100);
}

TEST_CASE("exchanged cameras and missing images give nothing, and no keyframe is kept for them") {
    Flight flight(test::plane_surface(Eigen::Vector3d::UnitZ(), 2.0));
    flight.view->is_exchanged = true;
    flight.visit({0.0, 0.0, 0.0});
    flight.view->is_exchanged = false;
    flight.fusion.add(*flight.view, 0, {}, {}, *flight.mesher);
    const auto image = test::draw(flight.surface, {0.5, 0.0, 0.0});
    flight.fusion.add_between({Eigen::Quaterniond::Identity(), {0.5, 0.0, 0.0}}, 0, image.view(), image.view());
    CHECK(flight.written().triangles.empty());
}

}  // namespace
}  // namespace facet::mesh_fusion_test
