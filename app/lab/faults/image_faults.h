// SPDX-License-Identifier: BSD-2-Clause
// What cameras do to a picture when light fails them.
#pragma once

#include <cstdint>

#include "drivers/replay_asl/png_decoder.h"

namespace facet {

/// No light: black level 2 with read noise of 1.5 grey values (1 sigma), drawn from `seed`. Reentrant.
void black_out(std::uint64_t seed, GreyImage& image);

/// Too much light: every pixel times `gain`, rounded, at most 255. Reentrant.
void overexpose(double gain, GreyImage& image);

/// A copy with rows without padding; `image` keeps its buffer. Reentrant.
void copy_image(const ImageView& view, GreyImage& image);

}  // namespace facet
