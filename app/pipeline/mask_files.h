// SPDX-License-Identifier: BSD-2-Clause
// Pictures of what each camera sees of the vehicle itself.
#pragma once

#include "app/calibration/calibration.h"
#include "drivers/replay_asl/grey_image.h"

namespace facet {

/// Decoded masks of a calibration: pixels that are black (0) are not used. An image without pixels masks nothing.
struct CameraMasks {
    GreyImage left;
    GreyImage right;
};

/// Reads Calibration::masks. Throws InputError naming the file if one cannot be read, is damaged, has another size than
/// its camera, or is black all over.
CameraMasks load_masks(const Calibration& calibration);

}  // namespace facet
