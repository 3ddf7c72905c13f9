// SPDX-License-Identifier: BSD-2-Clause
// Parameters of the mesher.
#pragma once

#include "mesh/face_filter.h"
#include "platform/base/parameter_field.h"
#include "platform/base/status.h"

namespace facet {

/// Units, ranges and meanings: kMeshFields below.
struct MeshConfig {
    /// The camera has flown through what is nearer to its path than this: there is no surface (m).
    static constexpr double kBodyRadius_m = 0.05;
    double max_depth_m = 8.0;
    FaceRules faces;

    /// kInvalidArgument if a field is outside its range.
    Status validate() const;
};

inline constexpr auto kMeshFields = std::to_array<ParameterField<MeshConfig>>({
    {FACET_FIELD(MeshConfig, max_depth_m), "m", 0.5, 100,
     "Landmarks farther than this from the newest keyframe give no new faces."},
});

}  // namespace facet
