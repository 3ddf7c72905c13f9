// SPDX-License-Identifier: BSD-2-Clause
// rays.csv: what the live grid says along rays from the vehicle, for facet eval.
#pragma once

#include <string>

#include "app/pipeline/frame_pipeline.h"
#include "app/support/text_file.h"

namespace facet {

/// 128 rays at each keyframe that brings a mesh, evenly spread over all azimuths and elevations up to 45 degrees,
/// turned from keyframe to keyframe. Columns: stamp_ns, position and unit direction in W, whether the left camera sees
/// that way, whether unknown space ends the free stretch, its length and the distance to the first occupied cell (m),
/// up to kRange_m, certainty and age (s) of what ends the stretch, or of the stretch itself if nothing does.
/// Throws InputError if it cannot be written. Thread-bound.
class RayLog {
public:
    static constexpr double kRange_m = 5.5;

    explicit RayLog(const std::string& folder);
    /// Does nothing for other frames.
    void write(const FrameResult& result, const FramePipeline& pipeline);
    void close() { file_.close(); }

private:
    TextFile file_;
    int keyframes_ = 0;
};

}  // namespace facet
