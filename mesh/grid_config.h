// SPDX-License-Identifier: BSD-2-Clause
// Parameters of the grid of free, occupied and unknown space.
#pragma once

#include "platform/base/parameter_field.h"
#include "platform/base/status.h"

namespace facet {

/// Units, ranges and meanings: kGridFields below.
struct GridConfig {
    bool enabled = true;
    double cell_m = 0.10;
    double max_ray_m = 6.0;
    double body_radius_m = 0.25;
    double forget_s = 600.0;
    double obstacle_grazing_deg = 65.0;

    /// kInvalidArgument if a field is outside its range.
    Status validate() const;
};

inline constexpr auto kGridFields = std::to_array<ParameterField<GridConfig>>({
    {FACET_FIELD(GridConfig, enabled), "-", 0, 1,
     "Keep a grid of free, occupied and unknown space around the vehicle; obstacles are reported from it."},
    {FACET_FIELD(GridConfig, cell_m), "m", 0.02, 0.5,
     "Side of a cell; the grid has 128 x 128 x 64 of them, centred on the vehicle."},
    {FACET_FIELD(GridConfig, max_ray_m), "m", 0.5, 50, "A line of sight carves free space up to this distance."},
    {FACET_FIELD(GridConfig, body_radius_m), "m", 0, 2,
     "What the vehicle has flown through is free to this distance from the camera's path."},
    {FACET_FIELD(GridConfig, forget_s), "s", 1, 3600,
     "Cells that nothing has confirmed for this time are unknown again."},
    {FACET_FIELD(GridConfig, obstacle_grazing_deg), "deg", 1, 90,
     "A face seen at a larger angle to its normal may bridge a step in depth: it makes no obstacle, but space that is "
     "not free."},
});

}  // namespace facet
