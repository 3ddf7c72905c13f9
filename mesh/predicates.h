// SPDX-License-Identifier: BSD-2-Clause
// Exact signs of the two determinants that a Delaunay triangulation needs.
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace facet {

/// Both functions give the sign of a determinant of the given coordinates, as if in exact arithmetic. They evaluate it
/// in plain floating point with a bound on the rounding error, and only if that cannot decide, as an expansion, an
/// exact sum of doubles [Shewchuk97]. The sign is exact unless a product overflows or underflows: |coordinate| in {0}
/// or [1e-60, 1e60] is safe. They rely on IEEE arithmetic in which a*b+c is not fused (the build's -ffp-contract=off).
/// Reentrant. No heap.

namespace predicates {

// Half the distance from 1 to the next double, the largest relative error of one rounding. From it follow the bounds of
// the plain evaluation's error relative to the sum of the magnitudes of its products [Shewchuk97, fig. 21, 22].
inline constexpr double kEpsilon = 0x1p-53;
inline constexpr double kOrientationBound = (3.0 + 16.0 * kEpsilon) * kEpsilon;
inline constexpr double kInCircleBound = (10.0 + 96.0 * kEpsilon) * kEpsilon;

/// The signs by expansions, always exact and slow.
double exact_orientation(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c);
double exact_in_circle(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c,
                       const Eigen::Vector2d& d);

}  // namespace predicates

/// Sign of
///   | ax-cx  ay-cy |
///   | bx-cx  by-cy |
/// > 0 if a, b, c turn counterclockwise, < 0 if clockwise, 0 if they are collinear. The value is twice the signed area
/// only approximately.
inline double orientation(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
    const double left = (a.x() - c.x()) * (b.y() - c.y());
    const double right = (a.y() - c.y()) * (b.x() - c.x());
    const double det = left - right;
    return std::abs(det) > predicates::kOrientationBound * (std::abs(left) + std::abs(right))
               ? det
               : predicates::exact_orientation(a, b, c);
}

/// Sign of
///   | ax-dx  ay-dy  (ax-dx)^2+(ay-dy)^2 |
///   | bx-dx  by-dy  (bx-dx)^2+(by-dy)^2 |
///   | cx-dx  cy-dy  (cx-dx)^2+(cy-dy)^2 |
/// > 0 if d lies inside the circle through a, b, c (in counterclockwise order), < 0 outside, 0 on it.
inline double in_circle(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c,
                        const Eigen::Vector2d& d) {
    const double adx = a.x() - d.x();
    const double ady = a.y() - d.y();
    const double bdx = b.x() - d.x();
    const double bdy = b.y() - d.y();
    const double cdx = c.x() - d.x();
    const double cdy = c.y() - d.y();
    const double bc = bdx * cdy;
    const double cb = cdx * bdy;
    const double ca = cdx * ady;
    const double ac = adx * cdy;
    const double ab = adx * bdy;
    const double ba = bdx * ady;
    const double a_lift = adx * adx + ady * ady;
    const double b_lift = bdx * bdx + bdy * bdy;
    const double c_lift = cdx * cdx + cdy * cdy;
    const double det = a_lift * (bc - cb) + b_lift * (ca - ac) + c_lift * (ab - ba);
    const double magnitude = (std::abs(bc) + std::abs(cb)) * a_lift + (std::abs(ca) + std::abs(ac)) * b_lift +
                             (std::abs(ab) + std::abs(ba)) * c_lift;
    return std::abs(det) > predicates::kInCircleBound * magnitude ? det : predicates::exact_in_circle(a, b, c, d);
}

}  // namespace facet
