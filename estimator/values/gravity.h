// SPDX-License-Identifier: BSD-2-Clause
// How strong gravity is: given, or computed from the place on Earth.
#pragma once

#include "platform/base/parameter_field.h"
#include "platform/base/status.h"

namespace facet {

/// Gravity on and above the WGS84 ellipsoid (m/s^2): Somigliana's formula for the ellipsoid, continued upwards to
/// second order in h / a,   [NIMA00] eq. (4-1), (4-3)
///   g0 = ge (1 + k sin^2 lat) / sqrt(1 - e^2 sin^2 lat)
///   g  = g0 (1 - 2 / a (1 + f + m - 2 f sin^2 lat) h + 3 h^2 / a^2)
/// From 9.780 at the equator to 9.832 at the poles, less by 0.003 per kilometre of height. Real gravity differs from it
/// by less than 0.002 (anomalies of the crust). Reentrant. No heap.
/// @param latitude_deg  geodetic, north or south (deg)
/// @param altitude_m    above the ellipsoid (m)
///
/// [NIMA00] Department of Defense World Geodetic System 1984, TR8350.2, 3rd ed.
double normal_gravity_m_per_s2(double latitude_deg, double altitude_m);

/// Units, ranges and meanings: kGravityFields below. The direction of gravity is estimated, its strength is not: an
/// error of it looks like a bias of the accelerometer that stays vertical while the body tilts.
struct GravityConfig {
    double magnitude_m_per_s2 = 9.81;
    bool from_latitude = false;
    double latitude_deg = 45.0;
    double altitude_m = 0.0;

    /// What the estimator uses (m/s^2).
    double norm_m_per_s2() const;
    /// kInvalidArgument if a field is outside its range.
    Status validate() const;
};

inline constexpr auto kGravityFields = std::to_array<ParameterField<GravityConfig>>({
    {FACET_FIELD(GravityConfig, magnitude_m_per_s2), "m/s^2", 1, 30,
     "Strength of gravity: 9.780 at the equator, 9.832 at the poles, less by 0.003 per kilometre of height."},
    {FACET_FIELD(GravityConfig, from_latitude), "-", 0, 1,
     "Compute gravity from latitude and altitude (WGS84 normal gravity) instead of using the magnitude given."},
    {FACET_FIELD(GravityConfig, latitude_deg), "deg", -90, 90,
     "Geodetic latitude of the flight, used if from_latitude is set; half a degree suffices."},
    {FACET_FIELD(GravityConfig, altitude_m), "m", -500, 20000,
     "Height above sea level, used if from_latitude is set; a hundred metres suffice."},
});

}  // namespace facet
