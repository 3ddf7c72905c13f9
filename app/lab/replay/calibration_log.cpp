// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/replay/calibration_log.h"

#include <array>

namespace facet {
namespace {

/// In the order of RigCalibration's tangent, the IMU's axes aside.
constexpr std::array<const char*, kImuScale> kParameters{
    "time_offset", "mount_theta_x", "mount_theta_y", "mount_theta_z", "mount_p_x",     "mount_p_y",
    "mount_p_z",   "left_fx",       "left_fy",       "left_cx",       "left_cy",       "left_d1",
    "left_d2",     "left_d3",       "left_d4",       "right_theta_x", "right_theta_y", "right_theta_z",
    "right_p_x",   "right_p_y",     "right_p_z",     "right_fx",      "right_fy",      "right_cx",
    "right_cy",    "right_d1",      "right_d2",      "right_d3",      "right_d4"};

}  // namespace

CalibrationLog::CalibrationLog(const std::string& folder) : file_(folder + "/calibration.csv") {
    file_.write("stamp_ns");
    for (const char* name : kParameters) {
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
