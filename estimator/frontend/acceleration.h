// SPDX-License-Identifier: BSD-2-Clause
// Acceleration of an iteration that converges linearly.
#pragma once

#include <Eigen/Core>
#include <algorithm>

namespace facet {

/// Anderson's acceleration, with a memory of one step [Anderson65], of a fixed-point iteration x -> x + f(x):
///   x+ = x + f - gamma (dx + df),   gamma = f . df / |df|^2,   dx, df: changes of x and f since the step before.
/// Where f shrinks at a rate r, f = r f_before, that is x + f / (1 - r): all that is left to go, at once. gamma stays between
/// those of the rates -0.43 and 0.75, because two steps that hardly differ tell little.
/// N parameters of about the same effect. No heap. Thread-bound.
template <int N>
class Acceleration {
public:
    using Vector = Eigen::Matrix<float, N, 1>;

    /// Where to go on from x, at which the iteration makes the step f.
    Vector next(const Vector& x, const Vector& f) {
        Vector to = x + f;
        const Vector df = f - f_before_;
        const float change = df.squaredNorm();
        if (has_before_ && change > 0.0F) {
            to -= std::clamp(f.dot(df) / change, kLeastGamma, kMostGamma) * (x - x_before_ + df);
        }
        x_before_ = x;
        f_before_ = f;
        has_before_ = true;
        return to;
    }

private:
    static constexpr float kLeastGamma = -3.0F;
    static constexpr float kMostGamma = 0.3F;

    bool has_before_ = false;
    Vector x_before_ = Vector::Zero();
    Vector f_before_ = Vector::Zero();
};

}  // namespace facet
