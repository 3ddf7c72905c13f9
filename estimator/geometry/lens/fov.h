// SPDX-License-Identifier: BSD-2-Clause
// The field-of-view model of wide lenses, also called ATAN.
#pragma once

#include <cmath>
#include <limits>
#include <numbers>

#include "estimator/geometry/lens/radial_scale.h"

namespace facet {

/// The bent radius grows evenly with the angle of a lens of the field of view w [Devernay01]:
///   r s = atan(2 r tan(w / 2)) / w
/// Valid for w within (0, pi). Coefficient: w (rad). Reentrant. No heap.
///
/// [Devernay01] Straight Lines Have to Be Straight, MVA 2001.
struct FovLens {
    static constexpr double kNearAxis = 1e-8;  ///< r^2 below which the series' first terms are exact to the last digit

    template <class T>
    static T scale(const T* k, const T& r2) {
        using std::atan;
        using std::sqrt;
        using std::tan;
        const T twice = T(2.0) * tan(T(0.5) * k[0]);
        if (!(r2 > T(kNearAxis))) {
            return twice / k[0] * (T(1.0) - twice * twice * r2 / T(3.0));
        }
        const T r = sqrt(r2);
        return atan(twice * r) / (k[0] * r);
    }

    static RadialScale scale_at(const double* k, double r2) {
        const double w = k[0];
        const double twice = 2.0 * std::tan(0.5 * w);
        const double d_twice = 1.0 + 0.25 * twice * twice;  // by w
        const double s = scale<double>(k, r2);
        if (!(r2 > kNearAxis)) {
            return {s, -twice * twice * twice / (3.0 * w), {d_twice * (1.0 - twice * twice * r2) / w - s / w, 0.0}};
        }
        const double grown = 1.0 / (w * (1.0 + twice * twice * r2));
        return {s, 0.5 * (twice * grown - s) / r2, {d_twice * grown - s / w, 0.0}};
    }

    /// r over the bent radius, of a bent point at the square m2 of its radius; not a number if no point is there.
    static double inverse_scale(const double* k, double m2) {
        const double w = k[0];
        const double twice = 2.0 * std::tan(0.5 * w);
        const double m = std::sqrt(m2);
        if (!(w * m < 0.5 * std::numbers::pi)) {
            return std::numeric_limits<double>::quiet_NaN();
        }
        return m2 > kNearAxis ? std::tan(w * m) / (twice * m) : w / twice;
    }
};

}  // namespace facet
