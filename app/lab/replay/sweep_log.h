// SPDX-License-Identifier: BSD-2-Clause
// sweeps.csv: the distances all around that a flight controller is sent, at each keyframe, for facet eval.
#pragma once

#include <string>

#include "app/pipeline/frame_pipeline.h"
#include "app/support/text_file.h"

namespace facet {

/// A row at each keyframe that brings a mesh. Columns: stamp_ns, position in W, azimuth of the middle of sector 0
/// (counterclockwise from W's x axis, rad), the band below and above (m), and the sectors' distances clockwise as in
/// ObstacleRanges: inf is free, nan unknown. Throws InputError if it cannot be written. Thread-bound.
class SweepLog {
public:
    explicit SweepLog(const std::string& folder);
    /// Does nothing for other frames.
    void write(const FrameResult& result, const FramePipeline& pipeline);
    void close() { file_.close(); }

private:
    static ObstacleOptions at_every_keyframe();

    TextFile file_;
    ObstacleOptions options_ = at_every_keyframe();
    ObstacleSweep sweep_{options_};
    std::string line_;
};

}  // namespace facet
