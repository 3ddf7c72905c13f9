// SPDX-License-Identifier: BSD-2-Clause
// Where in an image a patch is, near to where it is expected.
#pragma once

#include "mesh/places/descriptor.h"

namespace facet {

/// Aligns a patch, whose octave is given, by shifting it in the square: inverse-compositional Lucas-Kanade [Baker04] on
/// grey values without their mean, scaled to the patch's contrast. Reentrant. No heap.
/// @param uv  where its centre is then (px)
/// @return kNotFound if it leaves the image or ends further than a quarter of its side from where it was expected;
///         kDegenerate if it has too little texture, does not settle, or correlates by less than 0.8 (uv untouched)
Status search_patch(const ImagePyramid& pyramid, const UprightSquare& square, int octave, const UprightPatch& patch,
                    Eigen::Vector2d& uv);

}  // namespace facet
