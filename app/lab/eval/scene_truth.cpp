// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/scene_truth.h"

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "app/support/input_error.h"
#include "app/support/ply_reader.h"

namespace facet {
std::vector<EvalPlane> load_planes(const std::string& path) {
    std::vector<EvalPlane> planes;
    std::ifstream file(path);
    if (!file) {
        return planes;
    }
    try {
        const auto json = nlohmann::json::parse(file);  // outlives the loop, which a temporary here would not
        for (const auto& item : json.at("planes")) {
            EvalPlane plane;
            plane.name = item.value("name", "");
            const auto normal = item.at("normal").get<std::array<double, 3>>();
            plane.normal = Eigen::Vector3d(normal[0], normal[1], normal[2]);
            plane.offset = item.at("offset").get<double>();
            plane.seen_m2 = item.value("seen_area", 0.0);
            if (!(std::abs(plane.normal.norm() - 1.0) < 1e-3)) {
                throw InputError(path + ": a plane's normal is not a unit vector");
            }
            planes.push_back(plane);
        }
    } catch (const nlohmann::json::exception& e) {
        throw InputError(path + ": " + e.what());
    }
    return planes;
}

TriangleSoup load_mesh(const std::string& path) {
    PlyTriangles read;
    std::string error;
    if (!ok(read_ply(path, read, error))) {
        throw InputError(error);
    }
    if (read.triangles.empty()) {
        throw InputError(path + ": no triangle in it");
    }
    return {std::move(read.vertices), std::move(read.triangles)};
}

SceneTruth load_scene(const std::string& scene_ply, const CameraModel& left, const Se3& T_B_C0,
                      const std::vector<PosePair>& pairs, double pose_interval_s) {
    SceneTruth truth;
    truth.surface = load_mesh(scene_ply);
    truth.planes = load_planes((std::filesystem::path(scene_ply).parent_path() / "planes.json").string());
    truth.camera = left;
    Timestamp next{};
    for (const PosePair& pair : pairs) {
        if (truth.T_W_C0.empty() || pair.stamp >= next) {
            truth.T_W_C0.push_back(pair.truth * T_B_C0);
            next = pair.stamp + Duration::from_seconds(pose_interval_s);
        }
    }
    return truth;
}

}  // namespace facet
