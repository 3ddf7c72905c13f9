// SPDX-License-Identifier: BSD-2-Clause
// calibration.csv: how the corrections of the calibration develop over a replay.
#pragma once

#include <string>

#include "app/pipeline/frame_pipeline.h"
#include "app/support/text_file.h"

namespace facet {

/// A row for each keyframe with an estimate: stamp_ns, then for every parameter of both cameras its correction, named
/// and in units as in kCorrectionNames, and, in the column whose name ends in _sigma, its standard deviation (0 if not
/// estimated). The standard deviations cost a triangular solve each, which is not part of the frame's time. Throws
/// InputError if it cannot be written. Heap. Thread-bound.
class CalibrationLog {
public:
    explicit CalibrationLog(const std::string& folder);
    /// Does nothing for other frames.
    void write(const FrameResult& result, const FramePipeline& pipeline);
    void close() { file_.close(); }

private:
    TextFile file_;
};

}  // namespace facet
