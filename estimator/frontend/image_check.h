// SPDX-License-Identifier: BSD-2-Clause
// Decides whether an image can be tracked at all.
#pragma once

#include "estimator/frontend/frontend_types.h"
#include "platform/base/image_view.h"

namespace facet {

/// Judges an image by a coarse pyramid level, where noise is averaged out: dark or overexposed when nearly all pixels
/// are at one end of the range, flat when there is no contrast in between.
/// Reentrant. No heap.
ImageState check_image(const ImageView& coarse);

/// True if two images of one size are equal in every 16th row: the camera has delivered an old buffer again. Any two
/// exposures differ by their noise.
bool is_same_image(const ImageView& a, const ImageView& b);

/// Mean absolute difference of pixels two columns apart in every eighth row, over the mean grey value: independent of
/// gain and exposure as long as nothing saturates. @return 0 for an empty or black image
double relative_contrast(const ImageView& image);

}  // namespace facet
