// SPDX-License-Identifier: BSD-2-Clause
// Puts angular rates and specific forces that arrive separately together into inertial samples.
#pragma once

#include <cstdint>

#include "drivers/common/increasing_stamps.h"
#include "platform/base/ring_buffer.h"
#include "platform/base/samples.h"
#include "platform/base/status.h"

namespace facet {

struct ImuAssemblerCounters {
    std::uint64_t out_of_order = 0;  ///< measurements whose stamps did not increase: dropped
    std::uint64_t unpaired = 0;      ///< rates without forces close enough on both sides: dropped
    std::uint64_t overflowed = 0;    ///< rates dropped because no force came for too long
};

/// Two streams on one clock, in any interleaving, become samples at the stamps of the angular rates:
///   a(t) = a0 + (t - t0) / (t1 - t0) * (a1 - a0),  t0 <= t <= t1 the stamps of the neighbouring forces.
/// Rates keep their own stamps because attitude is more sensitive to time than velocity is. A rate waits until a force
/// at or after it has come; it is dropped if the forces around it are further apart than max_gap. The stamps of rates,
/// and so of samples, and those of forces strictly increase as IncreasingStamps has it, also across clear(). When full
/// (kCapacity rates wait): the oldest is dropped and counted. Thread-bound. No heap.
class ImuAssembler {
public:
    /// Rates that may wait: the longest burst of rates between two forces.
    static constexpr std::size_t kCapacity = 64;

    /// @param clock  that of the stamps
    explicit ImuAssembler(Duration max_gap = Duration::from_seconds(0.05), ClockDomain clock = ClockDomain::kMonotonic)
        : max_gap_(max_gap), rate_order_(clock), force_order_(clock) {}

    /// @return kOutOfOrder if the stamp does not increase: dropped and counted.
    Status add_rate(Timestamp stamp, const Eigen::Vector3d& w_B);
    Status add_force(Timestamp stamp, const Eigen::Vector3d& a_B);

    /// Next complete sample, in order of time.
    /// @return kNotReady if there is none yet
    Status pop(ImuSample& sample);

    /// Whether a rate waits, and so the next sample for a force; after pop() said that there is none.
    bool lacks_force() const { return !rates_.empty(); }

    /// Forgets waiting measurements; keeps the counters and the order.
    void clear();
    const ImuAssemblerCounters& counters() const { return counters_; }

private:
    struct Measurement {
        Timestamp stamp;
        Eigen::Vector3d value = Eigen::Vector3d::Zero();
    };
    /// Index of the first force at or after t; size if none.
    std::size_t force_at_or_after(Timestamp t) const;
    Duration max_gap_;
    RingBuffer<Measurement, kCapacity> rates_;
    RingBuffer<Measurement, kCapacity> forces_;
    IncreasingStamps rate_order_;
    IncreasingStamps force_order_;
    ImuAssemblerCounters counters_;
};

}  // namespace facet
