// SPDX-License-Identifier: BSD-2-Clause
#include "app/pipeline/mask_files.h"

#include <algorithm>

#include "app/support/input_error.h"
#include "drivers/replay_asl/image_decoder.h"

namespace facet {
namespace {

GreyImage load_mask(const std::string& path, const CameraIntrinsics& camera) {
    GreyImage mask;
    if (path.empty()) {
        return mask;
    }
    ImageDecoder decoder;
    if (!ok(decoder.decode(path, camera.width, camera.height, mask))) {
        throw InputError(path + ": as a mask: " + decoder.error());
    }
    if (std::all_of(mask.pixels.begin(), mask.pixels.end(), [](std::uint8_t pixel) { return pixel == 0; })) {
        throw InputError(path + ": as a mask: black all over, which leaves nothing of the camera's images");
    }
    return mask;
}

}  // namespace

CameraMasks load_masks(const Calibration& calibration) {
    return {load_mask(calibration.masks.left, calibration.rig.left.intrinsics()),
            load_mask(calibration.masks.right, calibration.rig.right.intrinsics())};
}

}  // namespace facet
