// SPDX-License-Identifier: BSD-2-Clause
// The double sphere model of fisheyes.
#pragma once

#include <cmath>
#include <limits>

#include "estimator/geometry/lens/radial_scale.h"

namespace facet {

/// Two unit spheres, the second moved by xi along the axis, and a pinhole alpha / (1 - alpha) behind it [Usenko18]:
///   s = 1 / (alpha d2 + (1 - alpha) k),  d1 = sqrt(1 + r^2),  k = xi d1 + 1,  d2 = sqrt(r^2 + k^2)
/// Valid where s is positive and r s grows with the angle. Coefficients: xi, alpha. Reentrant. No heap.
///
/// [Usenko18] The Double Sphere Camera Model, 3DV 2018.
struct DoubleSphereLens {
    template <class T>
    static T scale(const T* k, const T& r2) {
        using std::sqrt;
        const T along = k[0] * sqrt(T(1.0) + r2) + T(1.0);
        return T(1.0) / (k[1] * sqrt(r2 + along * along) + (T(1.0) - k[1]) * along);
    }

    static RadialScale scale_at(const double* k, double r2) {
        const double xi = k[0];
        const double alpha = k[1];
        const double d1 = std::sqrt(1.0 + r2);
        const double along = xi * d1 + 1.0;
        const double d2 = std::sqrt(r2 + along * along);
        const double s = 1.0 / (alpha * d2 + (1.0 - alpha) * along);
        const double d_along = 0.5 * xi / d1;
        const double d_d2 = (0.5 + along * d_along) / d2;
        return {s,
                -s * s * (alpha * d_d2 + (1.0 - alpha) * d_along),
                {-s * s * d1 * (alpha * along / d2 + 1.0 - alpha), -s * s * (d2 - along)}};
    }

    /// r over the bent radius, of a bent point at the square m2 of its radius; not a number if no point is there.
    static double inverse_scale(const double* k, double m2) {
        const double xi = k[0];
        const double alpha = k[1];
        const double z = (1.0 - alpha * alpha * m2) / (alpha * std::sqrt(1.0 - (2.0 * alpha - 1.0) * m2) + 1.0 - alpha);
        const double along = (z * xi + std::sqrt(z * z + (1.0 - xi * xi) * m2)) / (z * z + m2);
        const double depth = along * z - xi;
        return depth > 0.0 ? along / depth : std::numeric_limits<double>::quiet_NaN();
    }
};

}  // namespace facet
