// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/replay/ray_log.h"

#include <cmath>
#include <numbers>

namespace facet {
namespace {

constexpr int kRays = 128;
constexpr double kGolden_rad = 2.399963229728653;  // pi (3 - sqrt 5): the next azimuth of an even spread

}  // namespace

RayLog::RayLog(const std::string& folder) : file_(folder + "/rays.csv") {
    file_.write("stamp_ns,px,py,pz,dx,dy,dz,in_view,unknown,free_m,obstacle_m,certainty,age_s\n");
}

void RayLog::write(const FrameResult& result, const FramePipeline& pipeline) {
    const OccupancyGrid* const grid = pipeline.grid();
    if (!result.has_mesh || grid == nullptr) {
        return;
    }
    const NavState& state = result.estimate.state;
    const Se3 T_W_B{state.q_W_B, state.p_W_B};
    const Se3 T_C0_W = (T_W_B * pipeline.rig().T_B_C0).inverse();
    for (int i = 0; i < kRays; ++i) {
        const double z = std::numbers::sqrt2 * ((i + 0.5) / kRays - 0.5);
        const double azimuth = kGolden_rad * (i + 37 * keyframes_);
        const double level = std::sqrt(1.0 - z * z);
        const Eigen::Vector3d direction(level * std::cos(azimuth), level * std::sin(azimuth), z);
        Eigen::Vector2d uv;
        const bool is_in_view =
            ok(pipeline.rig().left.project(T_C0_W.q * direction, uv)) && pipeline.rig().left.in_image(uv, 0.0);
        const GridRay ray = grid->cast(state.p_W_B, direction, kRange_m);
        file_.print("{},{:.4f},{:.4f},{:.4f},{:.6f},{:.6f},{:.6f},{},{},{:.4f},{:.4f},{:.3f},{:.2f}\n",
                    result.output_stamp.ns, state.p_W_B.x(), state.p_W_B.y(), state.p_W_B.z(), direction.x(),
                    direction.y(), direction.z(), is_in_view ? 1 : 0, ray.end.space == Space::kUnknown ? 1 : 0,
                    ray.free_m, ray.obstacle_m, ray.end.certainty, ray.end.age_s);
    }
    ++keyframes_;
}

}  // namespace facet
