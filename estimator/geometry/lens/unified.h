// SPDX-License-Identifier: BSD-2-Clause
// The unified projection of mirrors and fisheyes: Kalibr's omni, camodocal's MEI.
#pragma once

#include <cmath>
#include <limits>

#include "estimator/geometry/lens/radial_scale.h"

namespace facet {

/// A unit sphere and a pinhole xi behind its centre [Mei07]:
///   s = 1 / (1 + xi sqrt(1 + r^2))
/// What leaves it is distorted as a point of a radial-tangential lens. Valid for xi >= 0 where r s grows with the
/// angle. Coefficient: xi. Reentrant. No heap.
///
/// [Mei07] Single View Point Omnidirectional Camera Calibration from Planar Grids, ICRA 2007.
struct UnifiedLens {
    template <class T>
    static T scale(const T* k, const T& r2) {
        using std::sqrt;
        return T(1.0) / (T(1.0) + k[0] * sqrt(T(1.0) + r2));
    }

    static RadialScale scale_at(const double* k, double r2) {
        const double d = std::sqrt(1.0 + r2);
        const double s = 1.0 / (1.0 + k[0] * d);
        return {s, -0.5 * s * s * k[0] / d, {-s * s * d, 0.0}};
    }

    /// r over the bent radius, of a bent point at the square m2 of its radius; not a number if no point is there.
    static double inverse_scale(const double* k, double m2) {
        const double xi = k[0];
        const double along = (xi + std::sqrt(1.0 + (1.0 - xi * xi) * m2)) / (m2 + 1.0);
        return along > xi ? along / (along - xi) : std::numeric_limits<double>::quiet_NaN();
    }
};

}  // namespace facet
