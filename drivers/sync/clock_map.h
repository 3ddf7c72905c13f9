// SPDX-License-Identifier: BSD-2-Clause
// Maps the stamps of one clock onto another, by a filtered offset and drift.
#pragma once

#include <cstdint>

#include "platform/base/status.h"
#include "platform/base/timestamp.h"

namespace facet {

struct ClockMapOptions {
    /// Noise of one pair (s): of two clocks read together some microseconds, of arrival times their jitter.
    double pair_sigma_s = 20e-6;
    /// How fast the drift wanders (1/sqrt(s)): crystals change by about 1e-7 in a minute.
    double drift_walk = 2e-8;
    /// Drift believed at first (1 sigma): crystals are good to 100e-6, the oscillators inside sensors to percents.
    double drift_sigma = 100e-6;
    /// Pairs are late by random delays, never early (arrival times): then the earliest ones count.
    bool one_sided = false;
    Duration step = Duration::from_seconds(0.010);  ///< a residual beyond this is an outlier, or a step of a clock
    int pairs_for_step = 5;                         ///< outliers in a row that make it a step
    int pairs_to_start = 3;
};

struct ClockMapCounters {
    std::uint64_t pairs = 0;
    std::uint64_t outliers = 0;
    std::uint64_t steps = 0;
};

/// Kalman filter of x = [offset o, drift d], where host - source = o at the time of the last pair and o' = d:
///   predict: o += d dt, d constant with random walk; update with z = host - source.
/// Reads as: host(t) = t + o + d (t - t_last). A step of either clock (the wall clock is set) is followed after
/// pairs_for_step pairs, and counted. Thread-bound. No heap.
class ClockMap {
public:
    explicit ClockMap(const ClockMapOptions& options = {}) : options_(options) {}

    /// The same instant on both clocks.
    /// @return kOutOfOrder if the source's stamp is not after the one before: not used; kCorrupt if it is an outlier.
    Status add(Timestamp source, Timestamp host);

    /// Whether enough pairs came.
    bool ready() const { return used_ >= options_.pairs_to_start; }
    /// Contract: ready().
    Timestamp to_host(Timestamp source) const;
    /// As to_host, for the stamps of a stream in order, so that they stay in order when the estimate moves.
    /// @return kNotReady before ready(); kOutOfOrder if the result is not after the one before: the sample must be dropped.
    Status map(Timestamp source, Timestamp& host);

    double drift() const { return drift_; }
    const ClockMapCounters& counters() const { return counters_; }

private:
    void restart(Timestamp source, Timestamp host);

    ClockMapOptions options_;
    ClockMapCounters counters_;
    int used_ = 0;
    int outliers_in_a_row_ = 0;
    Timestamp last_source_;
    Timestamp last_seen_;       ///< source's stamp of the last pair offered
    std::int64_t base_ns_ = 0;  ///< host - source of the first pair, so that doubles hold small numbers
    double offset_s_ = 0.0;     ///< beyond base, at last_source_
    double drift_ = 0.0;
    double p_oo_ = 0.0;  ///< covariance
    double p_od_ = 0.0;
    double p_dd_ = 0.0;
    bool any_mapped_ = false;
    Timestamp last_mapped_;
};

}  // namespace facet
