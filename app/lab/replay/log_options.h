// SPDX-License-Identifier: BSD-2-Clause
// What reading a log needs to know of its calibration.
#pragma once

#include "app/calibration/calibration.h"
#include "drivers/replay_asl/asl_dataset.h"

namespace facet {

/// Options with the cameras' number and image sizes and the shift of their clock; the rest as by default. Reentrant.
inline AslOptions log_options_of(const Calibration& calibration) {
    const auto size_of = [](const CameraModel& camera) -> ImageSize {
        return {camera.intrinsics().width, camera.intrinsics().height};
    };
    AslOptions options;
    options.camera_time_shift = calibration.camera_time_shift;
    options.left_size = size_of(calibration.rig.left);
    options.right_size = size_of(calibration.rig.right);
    options.left_only = !calibration.rig.has_right;
    return options;
}

}  // namespace facet
