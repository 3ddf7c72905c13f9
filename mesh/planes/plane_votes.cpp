// SPDX-License-Identifier: BSD-2-Clause
#include "mesh/planes/plane_votes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace facet {
namespace {

constexpr double kHeightBin = 2.0 * PlaneVotes::kReach / PlaneVotes::kHeightBins;
constexpr double kDistanceBin = 2.0 * PlaneVotes::kReach / PlaneVotes::kDistanceBins;
constexpr float kAzimuthBin = 2.0F * std::numbers::pi_v<float> / PlaneVotes::kAzimuthBins;
constexpr int kRadius = 4;  // bins of the kernel to each side
constexpr float kLeastSigmaBins = 0.8F;
constexpr float kMostSigmaBins = 2.0F;

/// Gaussian with peak one, so that the result is the support within about a sigma.
std::array<float, 2 * kRadius + 1> kernel_of(float sigma_bins) {
    const float sigma = std::clamp(sigma_bins, kLeastSigmaBins, kMostSigmaBins);
    std::array<float, 2 * kRadius + 1> kernel{};
    for (int k = -kRadius; k <= kRadius; ++k) {
        const float x = static_cast<float>(k) / sigma;
        kernel[static_cast<std::size_t>(k + kRadius)] = std::exp(-0.5F * x * x);
    }
    return kernel;
}

/// Correlation with the kernel; bins outside count as zero.
template <std::size_t N>
void smooth(std::array<float, N>& bins, const std::array<float, 2 * kRadius + 1>& kernel) {
    std::array<float, N + 2 * kRadius> padded{};
    std::copy(bins.begin(), bins.end(), padded.begin() + kRadius);
    bins.fill(0.0F);
    for (std::size_t k = 0; k < kernel.size(); ++k) {
        for (std::size_t i = 0; i < N; ++i) {
            bins[i] += kernel[k] * padded[i + k];
        }
    }
}

/// Vote at a place given in bins, shared by the two nearest. @return false if outside
template <std::size_t N>
bool add_shared(std::array<float, N>& bins, float at, float weight) {
    const float place = at - 0.5F;
    if (!(place >= 0.0F && place < static_cast<float>(N - 1))) {
        return false;
    }
    const auto i = static_cast<std::size_t>(place);
    const float upper = place - static_cast<float>(i);
    bins[i] += (1.0F - upper) * weight;
    bins[i + 1] += upper * weight;
    return true;
}

/// Place of the maximum between the neighbours of the largest bin, in bins from its middle.
float vertex_of_parabola(float before, float here, float after) {
    const float curvature = before - 2.0F * here + after;
    return curvature < 0.0F ? std::clamp(0.5F * (before - after) / curvature, -0.5F, 0.5F) : 0.0F;
}

}  // namespace

PlaneVotes::PlaneVotes() {
    for (int i = 0; i < kAzimuthBins + kLanes; ++i) {
        const float a = (static_cast<float>(i % kAzimuthBins) + 0.5F) * kAzimuthBin;
        direction_x_[i] = std::cos(a);
        direction_y_[i] = std::sin(a);
    }
    for (int k = 0; k < kLanes; ++k) {
        lane_[k] = static_cast<float>(k);
    }
}

void PlaneVotes::begin(const Eigen::Vector3d& origin_W) {
    origin_ = origin_W;
    for (auto& bins : heights_) {
        bins.fill(0.0F);
    }
    for (Row& row : walls_) {
        row.fill(0.0F);
    }
    level_weight_ = level_variance_ = upright_weight_ = upright_variance_ = 0.0F;
    peaks_.clear();
}

void PlaneVotes::vote_level(bool is_up, double z_W, float weight, float sigma_m) {
    const auto at = static_cast<float>((z_W - origin_.z() + kReach) / kHeightBin);
    if (add_shared(heights_[is_up ? 0 : 1], at, weight)) {
        level_weight_ += weight;
        level_variance_ += weight * sigma_m * sigma_m;
    }
}

void PlaneVotes::vote_upright(const Eigen::Vector3f& normal_W, float sigma_rad, const Eigen::Vector3d& centroid_W,
                              float weight, float sigma_m) {
    const Eigen::Vector2f offset = (centroid_W - origin_).head<2>().cast<float>();
    const float azimuth = std::atan2(normal_W.y(), normal_W.x());
    const float reach = 2.0F * sigma_rad + kAzimuthBin;  // where the vote ends
    const int first = static_cast<int>(std::ceil((azimuth - reach) / kAzimuthBin - 0.5F));
    const int last = static_cast<int>(std::floor((azimuth + reach) / kAzimuthBin - 0.5F));
    auto bin = static_cast<std::size_t>(((first % kAzimuthBins) + kAzimuthBins) % kAzimuthBins);
    for (int begin = first; begin <= last; begin += kLanes) {
        const Lanes azimuth_of = (static_cast<float>(begin) + lane_ + 0.5F) * kAzimuthBin;
        const Lanes off = (azimuth_of - azimuth) / reach;
        const Lanes taper = 1.0F - off * off;
        const Lanes share = weight * taper * taper;
        const auto row = static_cast<Eigen::Index>(bin);
        const Lanes distance =
            direction_x_.segment<kLanes>(row) * offset.x() + direction_y_.segment<kLanes>(row) * offset.y();
        const Lanes place = (distance + static_cast<float>(kReach)) / static_cast<float>(kDistanceBin) - 0.5F;
        const Lanes below = place.floor();
        const Lanes upper = (place - below) * share;
        const Lanes lower = (1.0F - (place - below)) * share;
        alignas(Lanes) std::array<std::array<float, kLanes>, 3> at;
        Eigen::Map<Lanes, Eigen::Aligned>(at[0].data()) = below;
        Eigen::Map<Lanes, Eigen::Aligned>(at[1].data()) = lower;
        Eigen::Map<Lanes, Eigen::Aligned>(at[2].data()) = upper;
        const auto rows = static_cast<std::size_t>(std::min(kLanes, last - begin + 1));
        for (std::size_t k = 0; k < rows; ++k) {
            if (at[0][k] >= 0.0F && at[0][k] < static_cast<float>(kDistanceBins - 1)) {
                float* const bins = &walls_[bin][static_cast<std::size_t>(at[0][k])];
                bins[0] += at[1][k];
                bins[1] += at[2][k];
            }
            bin = bin + 1 == kAzimuthBins ? 0 : bin + 1;
        }
    }
    upright_weight_ += weight;
    upright_variance_ += weight * sigma_m * sigma_m;
}

void PlaneVotes::keep(const PlanePeak& peak) {
    if (peaks_.full()) {
        if (peaks_.back().support_m2 >= peak.support_m2) {
            return;
        }
        peaks_.pop_back();
    }
    peaks_.push_back(peak);
    for (std::size_t i = peaks_.size() - 1; i > 0 && peaks_[i - 1].support_m2 < peaks_[i].support_m2; --i) {
        std::swap(peaks_[i - 1], peaks_[i]);
    }
}

/// Whether a smoothed bin of this row can reach `least`: none has more than the sum, which is known up to rounding.
bool PlaneVotes::may_peak(std::size_t azimuth, float least) const {
    return Eigen::Map<const Eigen::Array<float, kDistanceBins, 1>>(walls_[azimuth].data()).sum() > 0.99F * least;
}

void PlaneVotes::find_level(float least) {
    for (std::size_t side = 0; side < 2; ++side) {
        const auto& bins = heights_[side];
        for (std::size_t i = 2; i + 2 < bins.size(); ++i) {
            const float here = bins[i];
            if (here < least || here <= bins[i - 1] || here <= bins[i - 2] || here < bins[i + 1] ||
                here < bins[i + 2]) {
                continue;
            }
            const float at = static_cast<float>(i) + 0.5F + vertex_of_parabola(bins[i - 1], here, bins[i + 1]);
            const double z = origin_.z() - kReach + kHeightBin * static_cast<double>(at);
            const double sign = side == 0 ? 1.0 : -1.0;
            keep({PlaneKind::kHorizontal, sign * Eigen::Vector3d::UnitZ(), sign * z, here});
        }
    }
}

void PlaneVotes::find_upright(float least) {
    for (std::size_t a = 0; a < kAzimuthBins; ++a) {
        if (!may_peak_[a]) {
            continue;
        }
        const Row& row = walls_[a];
        for (std::size_t i = 2; i + 2 < row.size(); ++i) {
            const float here = row[i];
            if (here < least) {
                continue;
            }
            bool is_largest = true;
            for (std::size_t da = 0; da < 5 && is_largest; ++da) {  // azimuth wraps
                const Row& other = walls_[(a + kAzimuthBins + da - 2) % kAzimuthBins];
                for (std::size_t j = i - 2; j <= i + 2; ++j) {
                    const bool is_before = da < 2 || (da == 2 && j < i);
                    is_largest = is_largest && (is_before ? here > other[j] : here >= other[j]);
                }
            }
            if (is_largest) {
                const float at = static_cast<float>(i) + 0.5F + vertex_of_parabola(row[i - 1], here, row[i + 1]);
                const Eigen::Vector3d n(direction_x_[static_cast<int>(a)], direction_y_[static_cast<int>(a)], 0.0);
                keep({PlaneKind::kVertical, n, n.dot(origin_) - kReach + kDistanceBin * static_cast<double>(at), here});
            }
        }
    }
}

std::span<const PlanePeak> PlaneVotes::find_peaks(float min_support_m2) {
    if (level_weight_ > min_support_m2) {
        const auto kernel = kernel_of(std::sqrt(level_variance_ / level_weight_) / static_cast<float>(kHeightBin));
        for (auto& bins : heights_) {
            smooth(bins, kernel);
        }
        find_level(min_support_m2);
    }
    if (upright_weight_ > min_support_m2) {
        const auto kernel =
            kernel_of(std::sqrt(upright_variance_ / upright_weight_) / static_cast<float>(kDistanceBin));
        // Rows without a peak are only compared with, unsmoothed: they cannot exceed a peak.
        for (std::size_t a = 0; a < kAzimuthBins; ++a) {
            may_peak_[a] = may_peak(a, min_support_m2);
            if (may_peak_[a]) {
                smooth(walls_[a], kernel);
            }
        }
        find_upright(min_support_m2);
    }
    return {peaks_.data(), peaks_.size()};
}

}  // namespace facet
