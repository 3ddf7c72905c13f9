// SPDX-License-Identifier: BSD-2-Clause
// Parameters of the online calibration.
#pragma once

#include "platform/base/status.h"

namespace facet {

/// One line a field: meaning [unit] [range] and why this default.
struct CalibrationConfig {
    bool estimate_time_offset = true;    ///< between the cameras' clock and the IMU's
    double time_offset_sigma_s = 0.005;  ///< prior of the time offset [1e-6, 0.1]; what triggers leave open
    bool estimate_extrinsics = false;    ///< of the camera pair on the body; the calibration is usually better
    double rotation_sigma_rad = 0.01;    ///< prior of the pair's rotation [1e-6, 0.2]
    double translation_sigma_m = 0.005;  ///< prior of the pair's place [1e-6, 0.2]

    /// Parameters that are estimated: 0, 1 (time offset) or 7 (all; a time offset not wanted is then held by its prior).
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

}  // namespace facet
