// SPDX-License-Identifier: BSD-2-Clause
// Maps the stamps of one clock onto another, by a filtered offset and drift.
#pragma once

#include <cstdint>

#include "platform/base/status.h"
#include "platform/base/timestamp.h"

namespace facet {

struct ClockMapOptions {
    /// Noise of one pair (s): some microseconds if two clocks are read together; the jitter if arrival times are used.
    double pair_sigma_s = 20e-6;
    /// Random walk of the drift (1/sqrt(s)): crystals change by about 1e-7 in a minute.
    double drift_walk = 2e-8;
    /// Initial uncertainty of the drift (1 sigma): 100e-6 for crystals, some percent for the oscillators in sensors.
    double drift_sigma = 100e-6;
    /// Pairs are arrival times, which random delays make late but never early: the earliest ones get the weight, and
    /// one clearly earlier than foretold sets the offset again instead of being taken for drift.
    bool one_sided = false;
    Duration step = Duration::from_seconds(0.010);  ///< a larger residual is an outlier, or a clock has stepped
    int pairs_for_step = 5;                         ///< consecutive outliers that are taken for a step
    int pairs_to_start = 3;
};

struct ClockMapCounters {
    std::uint64_t pairs = 0;
    std::uint64_t outliers = 0;
    std::uint64_t steps = 0;
};

/// Kalman filter of x = [offset o, drift d], where host - source = o at the time of the last pair and o' = d:
///   predict: o += d dt, d constant with random walk; update with z = host - source.
/// The map is host(t) = t + o + d (t - t_last). A step of either clock (the wall clock was set) is followed after
/// pairs_for_step pairs, and counted. Thread-bound. No heap.
class ClockMap {
public:
    explicit ClockMap(const ClockMapOptions& options = {}) : options_(options) {}

    /// Adds a pair: the same instant on both clocks.
    /// @return kOutOfOrder if the source's stamp is not after the previous one: not used; kCorrupt if it is an outlier
    Status add(Timestamp source, Timestamp host);

    /// Whether enough pairs have been added.
    bool ready() const { return used_ >= options_.pairs_to_start; }
    /// Contract: ready().
    Timestamp to_host(Timestamp source) const;
    /// As to_host, for the stamps of one stream, which stay in order although the estimate moves.
    /// @param latest  the result cannot be after this: the present
    /// @return kNotReady before ready(); kOutOfOrder if the result is not after the previous one, kCorrupt if it is
    ///         after `latest`, as while a step is not yet known: drop the sample
    Status map(Timestamp source, Timestamp latest, Timestamp& host);

    double drift() const { return drift_; }
    const ClockMapCounters& counters() const { return counters_; }

private:
    void restart(Timestamp source, Timestamp host);

    ClockMapOptions options_;
    ClockMapCounters counters_;
    int used_ = 0;
    int outliers_in_a_row_ = 0;
    Timestamp last_source_;
    Timestamp last_seen_;       ///< source's stamp of the last pair, used or not
    std::int64_t base_ns_ = 0;  ///< host - source of the first pair: keeps the doubles below small
    double offset_s_ = 0.0;     ///< beyond base, at last_source_
    double drift_ = 0.0;
    double p_oo_ = 0.0;  ///< covariance
    double p_od_ = 0.0;
    double p_dd_ = 0.0;
    bool any_mapped_ = false;
    Timestamp last_mapped_;
};

}  // namespace facet
