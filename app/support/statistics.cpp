// SPDX-License-Identifier: BSD-2-Clause
#include "app/support/statistics.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace facet {

OrderStatistics::OrderStatistics(std::vector<double> samples) : sorted_(std::move(samples)) {
    std::sort(sorted_.begin(), sorted_.end());
}

double OrderStatistics::median() const {
    const std::size_t n = sorted_.size();
    return n == 0 || n % 2 == 1 ? upper_median() : 0.5 * (sorted_[n / 2 - 1] + sorted_[n / 2]);
}

double OrderStatistics::upper_median() const { return sorted_.empty() ? 0.0 : sorted_[sorted_.size() / 2]; }

double OrderStatistics::quantile(double share) const {
    if (sorted_.empty()) {
        return 0.0;
    }
    return sorted_[static_cast<std::size_t>(share * static_cast<double>(sorted_.size() - 1))];
}

double OrderStatistics::nearest_rank(double share) const {
    if (sorted_.empty()) {
        return 0.0;
    }
    const double rank = std::ceil(share * static_cast<double>(sorted_.size()));
    return sorted_[static_cast<std::size_t>(std::max(rank, 1.0)) - 1];
}

}  // namespace facet
