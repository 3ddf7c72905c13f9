// SPDX-License-Identifier: BSD-2-Clause
#include "estimator/values/gravity.h"

#include <cmath>
#include <numbers>

namespace facet {
namespace {

// WGS84, [NIMA00] tables 3.1, 3.3, 3.4.
constexpr double kEquatorGravity = 9.7803253359;     // ge (m/s^2)
constexpr double kSomigliana = 0.00193185265241;     // k
constexpr double kEccentricity2 = 0.00669437999014;  // e^2
constexpr double kFlattening = 1.0 / 298.257223563;  // f
constexpr double kSpin = 0.00344978650684;           // m = omega^2 a^2 b / GM
constexpr double kEquatorRadiusM = 6378137.0;        // a

}  // namespace

double normal_gravity_m_per_s2(double latitude_deg, double altitude_m) {
    const double sine = std::sin(latitude_deg * std::numbers::pi / 180.0);
    const double sine2 = sine * sine;
    const double h = altitude_m / kEquatorRadiusM;
    const double at_ellipsoid = kEquatorGravity * (1.0 + kSomigliana * sine2) / std::sqrt(1.0 - kEccentricity2 * sine2);
    return at_ellipsoid * (1.0 - 2.0 * (1.0 + kFlattening + kSpin - 2.0 * kFlattening * sine2) * h + 3.0 * h * h);
}

double GravityConfig::norm_m_per_s2() const {
    return from_latitude ? normal_gravity_m_per_s2(latitude_deg, altitude_m) : magnitude_m_per_s2;
}

Status GravityConfig::validate() const { return validate_fields(kGravityFields, *this); }

}  // namespace facet
