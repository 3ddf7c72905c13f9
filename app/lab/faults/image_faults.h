// SPDX-License-Identifier: BSD-2-Clause
// What cameras do to a picture when light, lens or sensor fail them.
#pragma once

#include <cstdint>

#include "drivers/replay_asl/png_decoder.h"

namespace facet {

/// No light: black level 2 with read noise of 1.5 grey values (1 sigma), drawn from `seed`. Reentrant, as all here.
void black_out(std::uint64_t seed, GreyImage& image);

/// A surface without texture: grey value 120 with noise of 1.5, drawn from `seed`.
void whiten(std::uint64_t seed, GreyImage& image);

/// Another exposure: every pixel times `gain`, rounded, at most 255.
void expose(double gain, GreyImage& image);

/// White noise of `sigma` grey values on every pixel, drawn from `seed`; saturates.
void add_pixel_noise(double sigma, std::uint64_t seed, GreyImage& image);

/// A smear of grease: within 0.4 image heights of a point left of the middle, a third of EuRoC's image, the picture is
/// the mean of 25 x 25 pixels and half veiled by a grey of 150. Heap.
void smear(GreyImage& image);

/// A copy with rows without padding; `image` keeps its buffer.
void copy_image(const ImageView& view, GreyImage& image);

}  // namespace facet
