// SPDX-License-Identifier: BSD-2-Clause
// Whether the images contradict the calibration: the mean of the residuals of each image coordinate.
#pragma once

#include <Eigen/Core>
#include <algorithm>

namespace facet {

/// Residuals of right parameters scatter about zero. A wrong calibration that the parameters cannot follow, because it
/// is trusted or of a kind that they do not model, shifts them all: by a tenth of a pixel where a calibration with the
/// usual errors of a good one is not estimated.
/// Means are weighted as in the optimization, so that outliers do not count, and forget over about kMemory keyframes.
/// Thread-bound. No heap.
class ResidualBias {
public:
    static constexpr double kMemory = 20.0;     ///< keyframes
    static constexpr double kEnough = 10000.0;  ///< sum of weights before anything is said: about ten full windows

    void reset() { *this = {}; }

    /// Takes an optimized window.
    /// @param weighted_px  sums of weight times residual of left u, left v, right u, right v (px)
    /// @param weights      sums of the weights of the left and of the right camera
    void add(const Eigen::Vector4d& weighted_px, const Eigen::Vector2d& weights) {
        constexpr double kKeep = 1.0 - 1.0 / kMemory;
        if (!weighted_px.allFinite() || !weights.allFinite()) {
            return;
        }
        weighted_px_ = kKeep * weighted_px_ + weighted_px;
        weights_ = kKeep * weights_ + weights;
    }

    /// The largest of the four means, absolute (px); 0 until enough has been seen.
    double largest_px() const {
        double largest = 0.0;
        for (int camera = 0; camera < 2; ++camera) {
            if (weights_(camera) > kEnough) {
                largest =
                    std::max(largest, weighted_px_.segment<2>(2 * camera).cwiseAbs().maxCoeff() / weights_(camera));
            }
        }
        return largest;
    }

private:
    Eigen::Vector4d weighted_px_ = Eigen::Vector4d::Zero();
    Eigen::Vector2d weights_ = Eigen::Vector2d::Zero();
};

}  // namespace facet
