// SPDX-License-Identifier: BSD-2-Clause
// Radial-tangential distortion of four, five or eight coefficients: OpenCV's plumb_bob and rational_polynomial.
#pragma once

#include <Eigen/Core>

#include "estimator/geometry/lens/radial_scale.h"

namespace facet {

/// The polynomial model [Brown66] and its extension by a sixth power and a denominator, as OpenCV has it:
///   x' = x radial + 2 p1 x y + p2 (r^2 + 2 x^2), y' likewise
///   radial = (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6)
/// Valid where the denominator is positive and r radial grows with r. `k` are k1 k2 p1 p2, `more` k3 k4 k5 k6.
/// Reentrant. No heap.
struct RationalLens {
    template <class T>
    static Eigen::Matrix<T, 2, 1> distort(const T* k, const double* more, const Eigen::Matrix<T, 2, 1>& xy) {
        const T r2 = xy.squaredNorm();
        const T above = T(1.0) + r2 * (k[0] + r2 * (k[1] + r2 * T(more[0])));
        const T below = T(1.0) + r2 * (T(more[1]) + r2 * (T(more[2]) + r2 * T(more[3])));
        const T radial = above / below;
        const T product = T(2.0) * xy.x() * xy.y();
        return {xy.x() * radial + k[2] * product + k[3] * (r2 + T(2.0) * xy.x() * xy.x()),
                xy.y() * radial + k[3] * product + k[2] * (r2 + T(2.0) * xy.y() * xy.y())};
    }

    /// The radial factor, its derivative by r^2, and those by k1 and k2.
    static RadialScale scale_at(const double* k, const double* more, double r2) {
        const double above = 1.0 + r2 * (k[0] + r2 * (k[1] + r2 * more[0]));
        const double below = 1.0 + r2 * (more[1] + r2 * (more[2] + r2 * more[3]));
        const double d_above = k[0] + r2 * (2.0 * k[1] + 3.0 * r2 * more[0]);
        const double d_below = more[1] + r2 * (2.0 * more[2] + 3.0 * r2 * more[3]);
        const double value = above / below;
        return {value, (d_above - value * d_below) / below, {r2 / below, r2 * r2 / below}};
    }

    static Eigen::Vector2d distort(const double* k, const double* more, const Eigen::Vector2d& xy, Eigen::Matrix2d* d) {
        const RadialScale radial = scale_at(k, more, xy.squaredNorm());
        const Eigen::Vector2d bent = radial.bend(xy, d);
        const double x = xy.x();
        const double y = xy.y();
        if (d != nullptr) {
            Eigen::Matrix2d tangential;
            tangential << 2.0 * k[2] * y + 6.0 * k[3] * x, 2.0 * k[2] * x + 2.0 * k[3] * y,
                2.0 * k[2] * x + 2.0 * k[3] * y, 6.0 * k[2] * y + 2.0 * k[3] * x;
            *d += tangential;
        }
        const double r2 = x * x + y * y;
        return bent + Eigen::Vector2d(2.0 * k[2] * x * y + k[3] * (r2 + 2.0 * x * x),
                                      k[2] * (r2 + 2.0 * y * y) + 2.0 * k[3] * x * y);
    }
};

}  // namespace facet
