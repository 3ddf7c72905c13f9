// SPDX-License-Identifier: BSD-2-Clause
// How far landmarks were seen from their predicted position: distinguishes a good calibration from a bad one.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace facet {

/// Histogram of one coordinate's residuals, with mean and standard deviation of all of them. No heap. Thread-bound.
class ResidualHistogram {
public:
    static constexpr int kBins = 81;  ///< odd: the middle one lies around zero
    static constexpr int kMiddle = kBins / 2;
    static constexpr double kBinPx = 0.05;

    /// Contract: finite.
    void add(double px) {
        const double bin = std::floor(px / kBinPx + 0.5 * kBins);
        if (bin >= 0.0 && bin < kBins) {
            ++counts_[static_cast<std::size_t>(bin)];
        }
        ++total_;
        sum_ += px;
        squares_ += px * px;
    }

    static double centre_px(int bin) { return kBinPx * (bin - kMiddle); }
    std::uint64_t count(int bin) const { return counts_[static_cast<std::size_t>(bin)]; }
    /// Includes values beyond the bins.
    std::uint64_t total() const { return total_; }
    /// 0 if nothing was added; so is deviation_px().
    double mean_px() const { return total_ == 0 ? 0.0 : sum_ / static_cast<double>(total_); }
    double deviation_px() const {
        const double mean = mean_px();
        return total_ == 0 ? 0.0 : std::sqrt(std::fmax(0.0, squares_ / static_cast<double>(total_) - mean * mean));
    }

private:
    std::array<std::uint64_t, kBins> counts_{};
    std::uint64_t total_ = 0;
    double sum_ = 0.0;
    double squares_ = 0.0;
};

/// Size of one camera's residuals over the angle between sight line and optical axis: level if observations are
/// weighted as precisely as they are, whatever the lens. No heap. Thread-bound.
class ResidualsByAngle {
public:
    static constexpr int kBins = 18;
    static constexpr double kBinDeg = 5.0;

    /// @param xy  undistorted normalised point, in front of the camera  @param r_px  its residual
    void add(const Eigen::Vector2d& xy, const Eigen::Vector2d& r_px) {
        constexpr double kBinRad = kBinDeg * std::numbers::pi / 180.0;
        const auto bin = static_cast<std::size_t>(std::fmin(std::atan(xy.norm()) / kBinRad, kBins - 1));
        ++counts_[bin];
        squares_[bin] += 0.5 * r_px.squaredNorm();
    }

    std::uint64_t count(int bin) const { return counts_[static_cast<std::size_t>(bin)]; }
    /// Root mean square of a coordinate (px); 0 if nothing was added.
    double rms_px(int bin) const {
        const auto i = static_cast<std::size_t>(bin);
        return counts_[i] == 0 ? 0.0 : std::sqrt(squares_[i] / static_cast<double>(counts_[i]));
    }

private:
    std::array<std::uint64_t, kBins> counts_{};
    std::array<double, kBins> squares_{};
};

/// Residuals of every keyframe's observations when it leaves the window as its oldest, so that each counts once and
/// with the final estimate; outliers are removed by then. Reprojected minus observed, undistorted, in pixels.
struct VisionResiduals {
    ResidualHistogram left_u;
    ResidualHistogram left_v;
    ResidualHistogram right_u;
    ResidualHistogram right_v;
    ResidualsByAngle left_by_angle;
    ResidualsByAngle right_by_angle;
};

}  // namespace facet
