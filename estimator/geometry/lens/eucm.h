// SPDX-License-Identifier: BSD-2-Clause
// The extended unified camera model.
#pragma once

#include <cmath>
#include <limits>

#include "estimator/geometry/lens/radial_scale.h"

namespace facet {

/// An ellipsoid of shape beta and a pinhole [Khomutenko16]:
///   s = 1 / (alpha q + 1 - alpha),  q = sqrt(beta r^2 + 1)
/// Valid where s is positive and r s grows with the angle. Coefficients: alpha, beta. Reentrant. No heap.
///
/// [Khomutenko16] An Enhanced Unified Camera Model, RA-L 2016.
struct EucmLens {
    template <class T>
    static T scale(const T* k, const T& r2) {
        using std::sqrt;
        return T(1.0) / (k[0] * sqrt(k[1] * r2 + T(1.0)) + T(1.0) - k[0]);
    }

    static RadialScale scale_at(const double* k, double r2) {
        const double alpha = k[0];
        const double beta = k[1];
        const double q = std::sqrt(beta * r2 + 1.0);
        const double s = 1.0 / (alpha * q + 1.0 - alpha);
        return {s, -s * s * alpha * 0.5 * beta / q, {-s * s * (q - 1.0), -s * s * alpha * 0.5 * r2 / q}};
    }

    /// r over the bent radius, of a bent point at the square m2 of its radius; not a number if no point is there.
    static double inverse_scale(const double* k, double m2) {
        const double alpha = k[0];
        const double beta = k[1];
        const double root = std::sqrt(1.0 - (2.0 * alpha - 1.0) * beta * m2);
        const double z = (1.0 - beta * alpha * alpha * m2) / (alpha * root + 1.0 - alpha);
        return z > 0.0 ? 1.0 / z : std::numeric_limits<double>::quiet_NaN();
    }
};

}  // namespace facet
