// SPDX-License-Identifier: BSD-2-Clause
// How far landmarks were seen from their predicted position: distinguishes a good calibration from a bad one.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

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

/// Residuals of every keyframe's observations when it leaves the window as its oldest, so that each counts once and
/// with the final estimate; outliers are removed by then. Reprojected minus observed, undistorted, in pixels.
struct VisionResiduals {
    ResidualHistogram left_u;
    ResidualHistogram left_v;
    ResidualHistogram right_u;
    ResidualHistogram right_v;
};

}  // namespace facet
