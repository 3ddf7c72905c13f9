// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/replay/sweep_log.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>

namespace facet {

ObstacleOptions SweepLog::at_every_keyframe() {
    ObstacleOptions options;
    options.rate_hz = 1e6;
    return options;
}

SweepLog::SweepLog(const std::string& folder) : file_(folder + "/sweeps.csv") {
    line_ = "stamp_ns,px,py,pz,ahead_rad,below_m,above_m";
    for (std::size_t k = 0; k < ObstacleRanges::kSectors; ++k) {
        fmt::format_to(std::back_inserter(line_), ",r{}_m", k);
    }
    file_.write(line_ + "\n");
}

void SweepLog::write(const FrameResult& result, const FramePipeline& pipeline) {
    if (!result.has_mesh) {
        return;
    }
    sweep_.update(pipeline.mesher().mesh());
    ObstacleRanges ranges;
    if (!sweep_.sweep(result.estimate, pipeline.grid(), ranges)) {
        return;
    }
    const NavState& state = result.estimate.state;
    const Eigen::Vector3d ahead_W = state.q_W_B * Eigen::Vector3d::UnitX();
    line_.clear();
    fmt::format_to(std::back_inserter(line_), "{},{:.4f},{:.4f},{:.4f},{:.6f},{:g},{:g}", result.output_stamp.ns,
                   state.p_W_B.x(), state.p_W_B.y(), state.p_W_B.z(), std::atan2(ahead_W.y(), ahead_W.x()),
                   options_.below_m, options_.above_m);
    for (const float range_m : ranges.range_m) {
        fmt::format_to(std::back_inserter(line_), ",{:.3f}", range_m);
    }
    file_.write(line_ + "\n");
}

}  // namespace facet
