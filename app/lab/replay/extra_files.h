// SPDX-License-Identifier: BSD-2-Clause
// What a replay writes only if it is asked to.
#pragma once

#include <optional>
#include <string>

#include "app/lab/fusion/mesh_fusion.h"
#include "app/lab/replay/calibration_log.h"
#include "app/lab/replay/ray_log.h"
#include "app/lab/replay/replay.h"
#include "app/lab/replay/sweep_log.h"
#include "app/output/place_log.h"
#include "app/pipeline/frame_pipeline.h"

namespace facet {

/// rays.csv, sweeps.csv and grid.png; mesh_fused.ply; calibration.csv; places.csv and trajectory_map.tum, and the map.
/// Thread-bound. Heap. Throws InputError if a file
/// cannot be written.
class ExtraFiles {
public:
    /// @param given  what the estimator was given
    ExtraFiles(const ReplayOptions& options, const StereoRig& given);

    /// After each frame. @param frame  with its images
    void write(const FrameResult& result, const FramePipeline& pipeline, const StereoFrame& frame);
    /// At the end. @param last  the newest frame's
    void finish(const FrameResult& last, const FramePipeline& pipeline);

private:
    void fuse(const FrameResult& result, const FramePipeline& pipeline, const StereoFrame& frame);

    std::string out_;
    std::optional<RayLog> rays_;
    std::optional<SweepLog> sweeps_;  ///< as rays_
    std::optional<MeshFusion> fusion_;
    std::optional<CalibrationLog> corrections_;
    std::optional<PlaceLog> places_;
    std::string map_;  ///< file of the places; empty: none
};

}  // namespace facet
