// SPDX-License-Identifier: BSD-2-Clause
// The look of things: procedural grey patterns with detail at many scales.
#pragma once

#include <cstdint>

#include "app/lab/sim/texture.h"

namespace facet::sim {

enum class Pattern : std::uint8_t {
    kPlain,    ///< nearly uniform plaster: hard to track on purpose
    kPlaster,  ///< stained wall
    kBrick,
    kPlanks,
    kTiles,
    kStone,     ///< masonry of uneven stones
    kConcrete,  ///< form lines, holes, cracks
    kFabric,
    kCarton,  ///< printed cardboard
    kMetal,   ///< riveted plates with rust streaks
    kEarth,   ///< gravel and soil
    kHazard,  ///< worn diagonal stripes
    kPanel,   ///< ceiling panels
    kBooks,   ///< rows of book spines
    kPoster,  ///< flat shapes and lines of print
    kPhoto,   ///< a landscape photograph
    kWindow,  ///< a window with mullions, a skyline behind
    kDoor,
    kBlotches,  ///< slow variation only, for multiplying others
};

/// Texture of a pattern, same seed same texture, identical for any number of threads.
/// @param size     texels a side, a power of two
Texture bake_pattern(Pattern pattern, std::uint32_t seed, int size, int threads);

}  // namespace facet::sim
