// SPDX-License-Identifier: BSD-2-Clause
// Planes through the parts of an image that have no texture.
#pragma once

#include <vector>

#include "mesh/volume/surface_patches.h"
#include "platform/base/image_view.h"

namespace facet {

/// The squares into which an image is divided.
struct SquareLayout {
    int side_px = 0;
    int columns = 0;
    int rows = 0;
    double per_px = 0.0;  ///< change of the inverse depth per pixel of disparity (1/m/px)
};

/// Gives squares without texture, in which nothing can be matched, the plane that their surroundings speak for. Squares
/// of even grey that run on without a step in it are taken for one region, since few edges in depth show none in grey.
/// A plane is laid through the patches at the region's rim; others of them may lie before it (what stands before a
/// wall), but hardly any behind. A square is filled if, seen from it across the region, rim patches on that plane lie
/// to opposite sides. Filled patches are marked as inferred, and claim no more than how far the rim may lie off it.
/// What is less certain than the mesh demands is not filled, since views that infer from one rim err alike.
/// Deterministic.
/// @param image    from which the patches come
/// @param patches  of each square, row by row
void fill_bare_squares(const ImageView& image, const SquareRaster& raster, const SquareLayout& layout,
                       std::vector<SurfacePatch>& patches);

}  // namespace facet
