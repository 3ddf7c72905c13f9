// SPDX-License-Identifier: BSD-2-Clause
// Parameters of a range finder that looks down.
#pragma once

#include "platform/base/parameter_field.h"
#include "platform/base/status.h"

namespace facet {

/// Units, ranges and meanings: kRangeFields below.
struct RangeConfig {
    /// A beam farther from the vertical than this meets walls rather than the ground: not used (deg).
    static constexpr double kMaxTilt_deg = 45.0;
    /// How much ground that passes for level rises or falls: a random walk with the distance flown over it (m/sqrt(m)).
    static constexpr double kUnevenness = 0.02;
    bool enabled = false;
    double sigma_m = 0.1;

    /// kInvalidArgument if a field is outside its range.
    Status validate() const;
};

inline constexpr auto kRangeFields = std::to_array<ParameterField<RangeConfig>>({
    {FACET_FIELD(RangeConfig, enabled), "-", 0, 1,
     "Use the readings of a range finder that looks down, from the log's range0/data.csv or from "
     "sinks.mavlink.range_finder: they hold changes of height over level ground."},
    {FACET_FIELD(RangeConfig, sigma_m), "m", 0.01, 1,
     "Standard deviation of a reading as the height of a level: less of what lies on the ground than of the sensor; "
     "0.02 "
     "over mats and rubble doubles the error of one camera."},
});

}  // namespace facet
