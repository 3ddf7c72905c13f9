// SPDX-License-Identifier: BSD-2-Clause
// Uniform quintic B-spline: four times continuously differentiable, derivatives in closed form.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace facet::sim {

/// Curve c(t) = sum_k N_k(u) * control[i + k], k = 0..5, in segment i = floor(t / step), u = t / step - i. It stays in
/// the convex hull of each segment's six control points. Times outside are clamped to the ends. de Boor, "A Practical
/// Guide to Splines", 1978. Evaluation: reentrant, no heap.
template <int kDim>
class QuinticSpline {
public:
    using Vector = Eigen::Matrix<double, kDim, 1>;
    struct Value {
        Vector x;
        Vector d1;  ///< first time derivative
        Vector d2;  ///< second time derivative
    };

    QuinticSpline() = default;
    /// @param step_s   knot spacing
    /// @param control  at least 6 points
    QuinticSpline(double step_s, std::vector<Vector> control) : step_s_(step_s), control_(std::move(control)) {}

    double duration_s() const { return step_s_ * (static_cast<double>(control_.size()) - 5.0); }

    Value evaluate(double t_s) const {
        const double place = std::clamp(t_s / step_s_, 0.0, static_cast<double>(control_.size()) - 5.0);
        const int segment = std::min(static_cast<int>(place), static_cast<int>(control_.size()) - 6);
        const double u = place - segment;
        Value out{Vector::Zero(), Vector::Zero(), Vector::Zero()};
        for (int k = 0; k < 6; ++k) {
            const double* c = kBasis[k];
            const Vector& p = control_[static_cast<std::size_t>(segment + k)];
            out.x += (c[0] + u * (c[1] + u * (c[2] + u * (c[3] + u * (c[4] + u * c[5]))))) * p;
            out.d1 += (c[1] + u * (2 * c[2] + u * (3 * c[3] + u * (4 * c[4] + u * 5 * c[5])))) * p;
            out.d2 += (2 * c[2] + u * (6 * c[3] + u * (12 * c[4] + u * 20 * c[5]))) * p;
        }
        const double scale = 1.0 / 120.0;
        out.x *= scale;
        out.d1 *= scale / step_s_;
        out.d2 *= scale / (step_s_ * step_s_);
        return out;
    }

private:
    /// 120 times the coefficients of u^0 .. u^5 of the six basis pieces.
    static constexpr double kBasis[6][6] = {{1, -5, 10, -10, 5, -1},  {26, -50, 20, 20, -20, 5},
                                            {66, 0, -60, 0, 30, -10}, {26, 50, 20, -20, -20, 10},
                                            {1, 5, 10, 10, 5, -5},    {0, 0, 0, 0, 0, 1}};

    double step_s_ = 1.0;
    std::vector<Vector> control_;
};

}  // namespace facet::sim
