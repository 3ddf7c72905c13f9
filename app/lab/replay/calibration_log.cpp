// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/replay/calibration_log.h"

#include "app/calibration/correction_names.h"

namespace facet {

CalibrationLog::CalibrationLog(const std::string& folder) : file_(folder + "/calibration.csv") {
    file_.write("stamp_ns");
    for (const char* name : kCorrectionNames) {
        file_.print(",{0},{0}_sigma", name);
    }
    file_.write("\n");
}

void CalibrationLog::write(const FrameResult& result, const FramePipeline& pipeline) {
    if (!result.is_keyframe || !result.is_usable) {
        return;
    }
    const CalibrationEstimate estimate = pipeline.calibration();
    const RigCalibration::Tangent correction = RigCalibration{}.box_minus_to(estimate.correction);
    file_.print("{}", result.output_stamp.ns);
    for (int i = 0; i < kImuScale; ++i) {
        file_.print(",{:.6g},{:.3g}", correction(i), estimate.sigma(i));
    }
    file_.write("\n");
}

}  // namespace facet
