// SPDX-License-Identifier: BSD-2-Clause
#include "app/output/frame_log.h"

#include <utility>

namespace facet {
namespace {

constexpr std::array<std::pair<std::uint32_t, const char*>, 24> kReasons{{
    {kReasonFewFeatures, "few_features"},
    {kReasonFewStereo, "few_stereo"},
    {kReasonNoRightImage, "no_right_image"},
    {kReasonImuGap, "imu_gap"},
    {kReasonBiasLimit, "bias_limit"},
    {kReasonHighResidual, "high_residual"},
    {kReasonSolverFailed, "solver_failed"},
    {kReasonImageRejected, "image_rejected"},
    {kReasonImageDark, "image_dark"},
    {kReasonImageOverexposed, "image_overexposed"},
    {kReasonImageFrozen, "image_frozen"},
    {kReasonImuClipped, "imu_clipped"},
    {kReasonVibration, "vibration"},
    {kReasonSpeedLimit, "speed_limit"},
    {kReasonVelocityUncertain, "velocity_uncertain"},
    {kReasonOverrun, "overrun"},
    {kReasonCalibration, "calibration"},
    {kReasonNoImages, "no_images"},
    {kReasonOneCamera, "one_camera"},
    {kReasonTriggerSilent, "trigger_silent"},
    {kReasonStalled, "stalled"},
    {kReasonImuContradicted, "imu_contradicted"},
    {kReasonFixedPattern, "fixed_pattern"},
    {kReasonRange, "range_finder"},
}};

/// One column of health.csv.
struct HealthColumn {
    const char* name;
    std::string (*text)(const Health&);
};

constexpr std::array kHealthColumns{
    HealthColumn{"state", [](const Health& h) { return std::string(to_string(h.state)); }},
    HealthColumn{"reasons", [](const Health& h) { return fmt::format("{}", h.reasons); }},
    HealthColumn{"reason_names", [](const Health& h) { return reason_names(h.reasons); }},
    HealthColumn{"quality", [](const Health& h) { return fmt::format("{}", h.quality); }},
    HealthColumn{"reset_counter", [](const Health& h) { return fmt::format("{}", h.reset_counter); }},
    HealthColumn{"is_keyframe", [](const Health& h) { return fmt::format("{:d}", h.is_keyframe); }},
    HealthColumn{"is_exchanged", [](const Health& h) { return fmt::format("{:d}", h.is_exchanged); }},
    HealthColumn{"is_still", [](const Health& h) { return fmt::format("{:d}", h.is_still); }},
    HealthColumn{"tracked", [](const Health& h) { return fmt::format("{}", h.tracked); }},
    HealthColumn{"detected", [](const Health& h) { return fmt::format("{}", h.detected); }},
    HealthColumn{"stereo", [](const Health& h) { return fmt::format("{}", h.stereo); }},
    HealthColumn{"recalled", [](const Health& h) { return fmt::format("{}", h.recalled); }},
    HealthColumn{"outliers", [](const Health& h) { return fmt::format("{}", h.outliers); }},
    HealthColumn{"fixed_share", [](const Health& h) { return fmt::format("{:.3g}", h.fixed_share); }},
    HealthColumn{"keyframes", [](const Health& h) { return fmt::format("{}", h.keyframes); }},
    HealthColumn{"landmarks", [](const Health& h) { return fmt::format("{}", h.landmarks); }},
    HealthColumn{"landmarks_dropped", [](const Health& h) { return fmt::format("{}", h.landmarks_dropped); }},
    HealthColumn{"iterations", [](const Health& h) { return fmt::format("{}", h.iterations); }},
    HealthColumn{"map_landmarks", [](const Health& h) { return fmt::format("{}", h.map_landmarks); }},
    HealthColumn{"frame_chi2", [](const Health& h) { return fmt::format("{:.4g}", h.frame_chi2); }},
    HealthColumn{"mean_vision_chi2", [](const Health& h) { return fmt::format("{:.6g}", h.mean_vision_chi2); }},
    HealthColumn{"pixel_sigma_px", [](const Health& h) { return fmt::format("{:.4g}", h.pixel_sigma_px); }},
    HealthColumn{"residual_bias_px", [](const Health& h) { return fmt::format("{:.3g}", h.residual_bias_px); }},
    HealthColumn{"calibration_stretch", [](const Health& h) { return fmt::format("{:.3g}", h.calibration_stretch); }},
    HealthColumn{"calibration_scale", [](const Health& h) { return fmt::format("{:.3g}", h.calibration_scale); }},
    HealthColumn{"imu_chi2", [](const Health& h) { return fmt::format("{:.6g}", h.imu_chi2); }},
    HealthColumn{"time_offset_s", [](const Health& h) { return fmt::format("{:.6g}", h.time_offset_s); }},
    HealthColumn{"time_offset_sigma_s", [](const Health& h) { return fmt::format("{:.3g}", h.time_offset_sigma_s); }},
    HealthColumn{"imu_gaps", [](const Health& h) { return fmt::format("{}", h.imu_gaps); }},
    HealthColumn{"imu_clipped", [](const Health& h) { return fmt::format("{}", h.imu_clipped); }},
    HealthColumn{"imu_dropped", [](const Health& h) { return fmt::format("{}", h.imu_dropped); }},
};

/// The columns of timing.csv that are of one clock.
struct TimeColumns {
    double SpentTime::*time;
    const char* ending;  ///< of their names
};

constexpr std::array kTimeColumns{
    TimeColumns{&SpentTime::wall_ms, "_ms"},
    TimeColumns{&SpentTime::processor_ms, "_cpu_ms"},
};

}  // namespace

std::string reason_names(std::uint32_t reasons) {
    std::string names;
    const auto add = [&](const std::string& name) { names += (names.empty() ? "" : "|") + name; };
    for (const auto& [bit, name] : kReasons) {
        if ((reasons & bit) != 0) {
            add(name);
            reasons &= ~bit;
        }
    }
    for (unsigned i = 0; reasons != 0; ++i, reasons >>= 1U) {
        if ((reasons & 1U) != 0) {
            add(fmt::format("bit{}", i));
        }
    }
    return names;
}

TimingWriter::TimingWriter(const std::string& folder) : file_(folder + "/timing.csv") {
    file_.write("stamp_ns,is_keyframe");
    for (const TimeColumns& columns : kTimeColumns) {
        file_.print(",total{0},estimate{0}", columns.ending);
        for (std::size_t i = 0; i < kStageCount; ++i) {
            file_.print(",{}{}", to_string(static_cast<Stage>(i)), columns.ending);
        }
    }
    file_.write("\n");
}

void TimingWriter::write(Timestamp stamp, bool is_keyframe, const FrameTiming& timing) {
    file_.print("{},{:d}", stamp.ns, is_keyframe);
    for (const TimeColumns& columns : kTimeColumns) {
        file_.print(",{:.4f},{:.4f}", timing.total.*columns.time, timing.estimate.*columns.time);
        for (const SpentTime& stage : timing.stages) {
            file_.print(",{:.4f}", stage.*columns.time);
        }
    }
    file_.write("\n");
}

HealthWriter::HealthWriter(const std::string& folder) : file_(folder + "/health.csv") {
    file_.write("stamp_ns");
    for (const HealthColumn& column : kHealthColumns) {
        file_.print(",{}", column.name);
    }
    file_.write("\n");
}

void HealthWriter::write(Timestamp stamp, const Health& health) {
    file_.print("{}", stamp.ns);
    for (const HealthColumn& column : kHealthColumns) {
        file_.print(",{}", column.text(health));
    }
    file_.write("\n");
}

}  // namespace facet
