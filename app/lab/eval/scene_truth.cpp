// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/eval/scene_truth.h"

#include <fmt/core.h>

#include <filesystem>
#include <utility>

#include "app/support/input_error.h"
#include "app/support/ply_reader.h"

namespace facet {
namespace {

constexpr double kMaxArea_m2 = 20'000.0;  // 1000 samples a square metre are a gigabyte

}  // namespace

TriangleSoup load_mesh(const std::string& path) {
    PlyTriangles read;
    std::string error;
    if (!ok(read_ply(path, read, error))) {
        throw InputError(error);
    }
    if (read.triangles.empty()) {
        throw InputError(path + ": no triangle in it");
    }
    TriangleSoup soup{std::move(read.vertices), std::move(read.triangles)};
    double area_m2 = 0.0;
    for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
        area_m2 += soup.area(i);
    }
    if (!(area_m2 <= kMaxArea_m2)) {
        throw InputError(fmt::format("{}: has {:.3g} m^2, more than the {:.0f} that can be compared; is it in metres?",
                                     path, area_m2, kMaxArea_m2));
    }
    return soup;
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
