// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/sim/range_finder.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>

#include "app/support/rng.h"

namespace facet::sim {

std::vector<RangeSample> find_ranges(const Scene& scene, std::span<const ImuRecord> imu, double sigma_m,
                                     std::uint64_t seed) {
    constexpr double kRate_hz = 50.0;
    constexpr double kTick_s = 1e-6;  // by which stamps may be rounded
    constexpr double kNearest_m = 0.05;
    constexpr double kFarthest_m = 8.0;
    constexpr std::uint64_t kPurpose = 77;
    std::vector<RangeSample> ranges;
    if (imu.empty()) {
        return ranges;
    }
    RandomStream random(seed, kPurpose);
    const Eigen::Vector3d down_B = imu.front().state.T_W_B.q.conjugate() * -Eigen::Vector3d::UnitZ();
    int taken = 0;
    for (const ImuRecord& record : imu) {
        if (record.t_s < taken / kRate_hz - kTick_s) {
            continue;
        }
        ++taken;
        const Se3& T_W_B = record.state.T_W_B;
        const RayHit hit = scene.cast(T_W_B.p, T_W_B.q * down_B);
        const double distance_m = hit.distance + sigma_m * random.normal();
        if (hit.surface >= 0 && distance_m >= kNearest_m && distance_m <= kFarthest_m) {
            ranges.push_back({record.sample.stamp, distance_m * down_B});
        }
    }
    return ranges;
}

Status write_ranges(const std::string& path, std::span<const RangeSample> ranges) {
    std::error_code code;
    std::filesystem::create_directories(std::filesystem::path(path).parent_path(), code);
    std::ofstream file(path);
    file << "#timestamp [ns],x [m],y [m],z [m]: the ground in the body\n";
    for (const RangeSample& r : ranges) {
        file << fmt::format("{},{:.6f},{:.6f},{:.6f}\n", r.stamp.ns, r.p_B.x(), r.p_B.y(), r.p_B.z());
    }
    file.close();
    return file ? Status::kOk : Status::kIo;
}

}  // namespace facet::sim
