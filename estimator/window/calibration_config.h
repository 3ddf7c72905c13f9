// SPDX-License-Identifier: BSD-2-Clause
// Parameters of the online calibration.
#pragma once

#include "platform/base/parameter_field.h"
#include "platform/base/status.h"

namespace facet {

/// Units, ranges and meanings: kCalibrationFields below.
struct CalibrationConfig {
    bool estimate_time_offset = true;
    double time_offset_sigma_s = 0.005;
    bool estimate_extrinsics = false;
    double rotation_sigma_rad = 0.01;
    double translation_sigma_m = 0.005;

    /// Number of parameters estimated: 0, 1 (time offset) or 7 (all; its prior then holds an unwanted time offset).
    int dim() const { return estimate_extrinsics ? 7 : (estimate_time_offset ? 1 : 0); }
    /// Standard deviation of the prior of a parameter, order [time_offset theta p].
    double sigma(int parameter) const {
        const double unwanted_time_offset_s = 1e-7;
        if (parameter == 0) {
            return estimate_time_offset ? time_offset_sigma_s : unwanted_time_offset_s;
        }
        return parameter < 4 ? rotation_sigma_rad : translation_sigma_m;
    }
    /// kInvalidArgument if a field is outside its range.
    Status validate() const;
};

inline constexpr auto kCalibrationFields = std::to_array<ParameterField<CalibrationConfig>>({
    {FACET_FIELD(CalibrationConfig, estimate_time_offset), "-", 0, 1,
     "Estimate the time offset between the clocks of the cameras and of the IMU."},
    {FACET_FIELD(CalibrationConfig, time_offset_sigma_s), "s", 1e-6, 0.1,
     "Standard deviation of the time offset before the first estimate; the default is what triggering leaves open."},
    {FACET_FIELD(CalibrationConfig, estimate_extrinsics), "-", 0, 1,
     "Estimate how the camera pair is mounted on the body; off, because the given calibration is usually better."},
    {FACET_FIELD(CalibrationConfig, rotation_sigma_rad), "rad", 1e-6, 0.2,
     "Standard deviation of the given rotation of the camera pair on the body."},
    {FACET_FIELD(CalibrationConfig, translation_sigma_m), "m", 1e-6, 0.2,
     "Standard deviation of the given position of the camera pair on the body."},
});

}  // namespace facet
