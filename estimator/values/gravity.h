// SPDX-License-Identifier: BSD-2-Clause
// How strong gravity is.
#pragma once

#include "platform/base/parameter_field.h"
#include "platform/base/status.h"

namespace facet {

/// Units, ranges and meanings: kGravityFields below. The direction of gravity is estimated, its strength is not: an
/// error of it looks like a bias of the accelerometer that stays vertical while the body tilts.
struct GravityConfig {
    double magnitude_m_per_s2 = 9.81;

    /// kInvalidArgument if a field is outside its range.
    Status validate() const;
};

inline constexpr auto kGravityFields = std::to_array<ParameterField<GravityConfig>>({
    {FACET_FIELD(GravityConfig, magnitude_m_per_s2), "m/s^2", 1, 30,
     "Strength of gravity: 9.780 at the equator, 9.806 at 45 degrees, 9.832 at the poles, less by 0.003 per kilometre "
     "of height."},
});

}  // namespace facet
