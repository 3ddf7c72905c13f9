// SPDX-License-Identifier: BSD-2-Clause
// Parameters of the map of surfaces.
#pragma once

#include "platform/base/parameter_field.h"
#include "platform/base/status.h"

namespace facet {

/// Units, ranges and meanings: kMapFields below.
struct MapConfig {
    bool enabled = true;
    int square_px = 8;
    int steps_per_frame = 2000;
    int max_blocks = 8192;

    /// kInvalidArgument if a field is outside its range.
    Status validate() const;
};

inline constexpr auto kMapFields = std::to_array<ParameterField<MapConfig>>({
    {FACET_FIELD(MapConfig, enabled), "-", 0, 1,
     "Keep a map of the surfaces around the vehicle: signed distances, from the depth of keyframes' pixels. Without "
     "anybody who reads it (files of a run, viewers), or without a right camera, nothing is mapped."},
    {FACET_FIELD(MapConfig, square_px), "px", 4, 64,
     "One pixel is matched in each square of this side; images with more than 32768 squares use larger ones."},
    {FACET_FIELD(MapConfig, steps_per_frame), "-", 50, 1000000,
     "Of a replay: bound on the map's work after each frame's estimate, in steps of about 5 us (a pixel matched, a "
     "block of voxels brought up to date); keyframes that come before the work on earlier ones is done are left out."},
    {FACET_FIELD(MapConfig, max_blocks), "-", 256, 262144,
     "The map holds this many cubes of 32 cm where there are surfaces, 8 KB each; when they are used up, those "
     "farthest from the vehicle leave."},
});

}  // namespace facet
