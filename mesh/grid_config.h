// SPDX-License-Identifier: BSD-2-Clause
// Parameters of the grid of free, occupied and unknown space.
#pragma once

#include "platform/base/parameter_field.h"
#include "platform/base/status.h"

namespace facet {

/// Units, ranges and meanings: kGridFields below.
struct GridConfig {
    bool enabled = true;
    bool match_pixels = true;
    double cell_m = 0.10;
    double max_ray_m = 6.0;
    double body_radius_m = 0.25;

    /// kInvalidArgument if a field is outside its range.
    Status validate() const;
};

inline constexpr auto kGridFields = std::to_array<ParameterField<GridConfig>>({
    {FACET_FIELD(GridConfig, enabled), "-", 0, 1,
     "Keep a grid of free, occupied and unknown space around the vehicle; obstacles are reported from it."},
    {FACET_FIELD(GridConfig, match_pixels), "-", 0, 1,
     "Match pixels between the corners in stereo at each keyframe: more of the grid's space becomes free or occupied. "
     "Without anybody who reads the grid (--stream, --rays, OBSTACLE_DISTANCE), nothing is matched."},
    {FACET_FIELD(GridConfig, cell_m), "m", 0.02, 0.5,
     "Side of a cell; the grid has 128 x 128 x 64 of them, centred on the vehicle."},
    {FACET_FIELD(GridConfig, max_ray_m), "m", 0.5, 50, "A line of sight carves free space up to this distance."},
    {FACET_FIELD(GridConfig, body_radius_m), "m", 0, 2,
     "What the vehicle has flown through is free to this distance from the camera's path."},
});

}  // namespace facet
