// SPDX-License-Identifier: BSD-2-Clause
// Robust losses on whitened squared residuals.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

namespace facet {

/// Huber's loss on s = |r|^2 (whitened): rho(s) = s for s <= k^2, else 2 k sqrt(s) - k^2.   [Huber64]
/// Costs are 1/2 rho; the weight rho'(s) scales J^T J and J^T r (no second-order correction). slope(s) is the
/// derivative of the influence psi(r) = rho'(s) r of a residual in the plane, averaged over directions:
/// rho'(s) + s rho''(s).
/// Reentrant. No heap.
struct HuberLoss {
    double threshold = 1.5;  ///< k, in standard deviations

    double cost(double s) const {
        const double k2 = threshold * threshold;
        return s <= k2 ? 0.5 * s : threshold * std::sqrt(s) - 0.5 * k2;
    }
    double weight(double s) const { return s <= threshold * threshold ? 1.0 : threshold / std::sqrt(s); }
    double slope(double s) const { return s <= threshold * threshold ? 1.0 : 0.5 * threshold / std::sqrt(s); }
};

/// Cauchy's loss: rho(s) = k^2 log(1 + s / k^2), the likelihood of Student's t with heavy tails. Far outliers lose all
/// influence, so it must not be used before the state is roughly right. [Zhang97]
struct CauchyLoss {
    double threshold = 1.5;  ///< k, in standard deviations

    double cost(double s) const {
        const double k2 = threshold * threshold;
        return 0.5 * k2 * std::log1p(s / k2);
    }
    /// The sum over several residuals, of products: a logarithm costs as much as ten of them.
    double cost(std::span<const double> squares) const {
        constexpr double kLarge = 1e150;  // a factor more does not overflow
        const double k2 = threshold * threshold;
        double logarithms = 0.0;
        double product = 1.0;
        for (const double s : squares) {
            product *= 1.0 + s / k2;
            if (product > kLarge) {
                logarithms += std::log(product);
                product = 1.0;
            }
        }
        return 0.5 * k2 * (logarithms + std::log(product));
    }
    double weight(double s) const { return 1.0 / (1.0 + s / (threshold * threshold)); }
    double slope(double s) const { return weight(s) * weight(s); }
};

/// Tukey's biweight loss: rho(s) = k^2 / 3 (1 - (1 - u)^3) with u = p s / k^2, constant beyond u = 1, where residuals
/// have no influence at all. [Beaton74]
struct TukeyLoss {
    double threshold = 4.6851;  ///< k, in standard deviations; 95 % efficient with normal errors
    double precision = 1.0;     ///< p: of the residual, over that of those it was whitened with

    double cost(double s) const {
        const double inside = core(s);
        return threshold * threshold / 6.0 * (1.0 - inside * inside * inside);
    }
    double weight(double s) const { return precision * core(s) * core(s); }
    double slope(double s) const { return precision * core(s) * (3.0 * core(s) - 2.0); }

private:
    double core(double s) const { return std::max(0.0, 1.0 - precision * s / (threshold * threshold)); }
};

enum class LossKind : std::uint8_t { kHuber, kCauchy, kTukey };

/// One of them, chosen at run time.
struct RobustLoss {
    double threshold = 1.5;  ///< in standard deviations
    LossKind kind = LossKind::kHuber;
    double precision = 1.0;  ///< of Tukey's

    double cost(double s) const {
        switch (kind) {
            case LossKind::kHuber: return HuberLoss{threshold}.cost(s);
            case LossKind::kCauchy: return CauchyLoss{threshold}.cost(s);
            case LossKind::kTukey: break;
        }
        return TukeyLoss{threshold, precision}.cost(s);
    }
    /// The sum over several residuals.
    double cost(std::span<const double> squares) const {
        if (kind == LossKind::kCauchy) {
            return CauchyLoss{threshold}.cost(squares);
        }
        double sum = 0.0;
        for (const double s : squares) {
            sum += cost(s);
        }
        return sum;
    }
    double weight(double s) const {
        switch (kind) {
            case LossKind::kHuber: return HuberLoss{threshold}.weight(s);
            case LossKind::kCauchy: return CauchyLoss{threshold}.weight(s);
            case LossKind::kTukey: break;
        }
        return TukeyLoss{threshold, precision}.weight(s);
    }
    double slope(double s) const {
        switch (kind) {
            case LossKind::kHuber: return HuberLoss{threshold}.slope(s);
            case LossKind::kCauchy: return CauchyLoss{threshold}.slope(s);
            case LossKind::kTukey: break;
        }
        return TukeyLoss{threshold, precision}.slope(s);
    }
};

/// Sums over the residuals of points in images under a loss.
struct LossSums {
    int points = 0;
    double squared_error = 0.0;      ///< |r|^2, whitened, not robust
    double weight = 0.0;             ///< rho'
    double slope = 0.0;              ///< of the influence psi = rho' r
    double squared_influence = 0.0;  ///< |psi|^2

    void operator+=(const LossSums& other) {
        points += other.points;
        squared_error += other.squared_error;
        weight += other.weight;
        slope += other.slope;
        squared_influence += other.squared_influence;
    }
};

}  // namespace facet
