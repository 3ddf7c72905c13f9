// SPDX-License-Identifier: BSD-2-Clause
// Parameters of semi-dense depth.
#pragma once

#include "platform/base/parameter_field.h"
#include "platform/base/status.h"

namespace facet {

/// Units, ranges and meanings: kDepthFields below.
struct DepthConfig {
    bool enabled = true;
    int bucket_px = 14;
    int pixels_per_frame = 500;
    double min_gradient = 4.0;
    int reach_px = 4;
    double min_depth_m = 0.6;
    double search_px = 6.0;
    double min_correlation = 0.8;
    int neighbours = 2;

    /// kInvalidArgument if a field is outside its range.
    Status validate() const;
};

inline constexpr auto kDepthFields = std::to_array<ParameterField<DepthConfig>>({
    {FACET_FIELD(DepthConfig, enabled), "-", 0, 1,
     "Match pixels between the corners in stereo at each keyframe: more of the grid's space becomes free or occupied. "
     "Without a grid, or without anybody who reads it (--stream, --rays, OBSTACLE_DISTANCE), nothing is matched."},
    {FACET_FIELD(DepthConfig, bucket_px), "px", 4, 100,
     "One pixel is matched in each square of this side; images with more than 4096 squares use larger ones."},
    {FACET_FIELD(DepthConfig, pixels_per_frame), "-", 10, 4096,
     "At most this many squares are looked at in each frame after a keyframe; what is left when the next keyframe "
     "comes "
     "is dropped."},
    {FACET_FIELD(DepthConfig, min_gradient), "-", 0.5, 255,
     "Least change of grey along the epipolar line, per pixel, of a pixel to be matched."},
    {FACET_FIELD(DepthConfig, reach_px), "px", 2, 15,
     "The window that is compared reaches this far from the pixel to every side."},
    {FACET_FIELD(DepthConfig, min_depth_m), "m", 0.05, 10, "Nothing nearer than this is searched for."},
    {FACET_FIELD(DepthConfig, search_px), "px", 1, 100,
     "The search goes this far beyond the depths of the corners of the triangle that holds the pixel; outside all "
     "triangles it covers all depths."},
    {FACET_FIELD(DepthConfig, min_correlation), "-", 0, 1, "Least normalised correlation of a match."},
    {FACET_FIELD(DepthConfig, neighbours), "-", 0, 8,
     "Number of the eight squares around a match whose matches must agree with it in depth."},
});

}  // namespace facet
