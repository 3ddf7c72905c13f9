// SPDX-License-Identifier: BSD-2-Clause
// Pictures of the residuals over the image: what the calibration does not explain shows as a pattern.
#pragma once

#include <string>
#include <vector>

#include "app/lab/calibrate/batch.h"

namespace facet {

/// Draws the image plane of a camera in white: every sighting's residual as a light grey line, 10 times as long, from
/// where it was seen; over it the mean of each cell of 40 px as a black line, 100 times as long, from a dot at the
/// cell's centre. With a good calibration there are dots and grey noise.
/// Throws InputError if the file cannot be written. Heap.
void write_residual_picture(const std::string& path, const CameraIntrinsics& size,
                            const std::vector<SightingResidual>& residuals, int camera);

}  // namespace facet
