// SPDX-License-Identifier: BSD-2-Clause
// Order statistics of a set of samples.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace facet {

/// A sorted copy of n samples and what can be read from it by rank, rank 0 being the smallest sample. All results are
/// samples, except the median of an even number of them; all are 0 if there are none. Samples must not be NaN.
///
/// The quantiles differ by less than one rank. Reports keep the one they were introduced with, so that figures of
/// different versions can be compared.
class OrderStatistics {
public:
    explicit OrderStatistics(std::vector<double> samples);

    std::size_t count() const { return sorted_.size(); }
    /// In increasing order.
    std::span<const double> sorted() const { return sorted_; }
    double max() const { return sorted_.empty() ? 0.0 : sorted_.back(); }

    /// The middle sample, or the mean of the two middle ones.
    double median() const;
    /// The middle sample, or the larger of the two middle ones: rank floor(n / 2).
    double upper_median() const;
    /// The sample of rank floor(share (n - 1)), share in [0, 1].
    double quantile(double share) const;
    /// The smallest sample that at least this share of all samples does not exceed: rank ceil(share n) - 1, share in
    /// (0, 1].
    double nearest_rank(double share) const;

private:
    std::vector<double> sorted_;
};

}  // namespace facet
