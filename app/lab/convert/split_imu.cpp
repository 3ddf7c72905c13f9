// SPDX-License-Identifier: BSD-2-Clause
#include "app/lab/convert/split_imu.h"

#include <algorithm>

namespace facet {

std::uint64_t SplitImu::finish(const Give& give) {
    std::ranges::stable_sort(rates_, {}, &Reading::stamp_ns);
    std::ranges::stable_sort(forces_, {}, &Reading::stamp_ns);
    std::uint64_t left_out = 0;
    std::size_t after = 0;
    std::int64_t last_ns = 0;
    for (const Reading& rate : rates_) {
        while (after < forces_.size() && forces_[after].stamp_ns < rate.stamp_ns) {
            ++after;
        }
        const bool is_at = after < forces_.size() && forces_[after].stamp_ns == rate.stamp_ns;
        const bool is_between =
            after > 0 && after < forces_.size() && forces_[after].stamp_ns - forces_[after - 1].stamp_ns <= kGap_ns;
        if ((!is_at && !is_between) || rate.stamp_ns <= last_ns) {
            ++left_out;
            continue;
        }
        last_ns = rate.stamp_ns;
        const Reading& b = forces_[after];
        const Reading& a = is_at ? b : forces_[after - 1];
        const double s =
            is_at ? 0.0
                  : static_cast<double>(rate.stamp_ns - a.stamp_ns) / static_cast<double>(b.stamp_ns - a.stamp_ns);
        std::array<double, 6> sample{};
        for (std::size_t i = 0; i < 3; ++i) {
            sample[i] = rate.values[i];
            sample[3 + i] = a.values[i] + s * (b.values[i] - a.values[i]);
        }
        give(rate.stamp_ns, sample);
    }
    rates_.clear();
    forces_.clear();
    return left_out;
}

}  // namespace facet
