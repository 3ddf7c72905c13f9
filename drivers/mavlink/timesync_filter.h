// SPDX-License-Identifier: BSD-2-Clause
// Finds the offset of another machine's clock by asking for its time over a link that delays what it carries.
#pragma once

#include <array>
#include <cstdint>

#include "platform/base/status.h"
#include "platform/base/timestamp.h"

namespace facet {

/// A question sent at s and answered at r with the remote time m bounds the offset o = remote - own, since delays are
/// not negative: m - r <= o <= m - s. Of a block of kBlock exchanges, brought to one instant by the drift known so far,
/// the least upper and the greatest lower bound are those of the least delays on either way; their middle is one
/// measurement of a Kalman filter of [o, d], o' = d. What the least delays vary by is taken from how much the round
/// trips vary:
///   z = (max(m - r) + min(m - s)) / 2,    sigma = sigma_0 + 1.5 (mean(r - s) - min(r - s)) / kBlock
/// A delay that is always longer on one way than on the other cannot be seen by any such exchange. An exchange whose
/// bounds contradict the offset proves that a clock has stepped; after kForStep in a row the filter starts over.
/// Thread-bound. No heap.
class TimesyncFilter {
public:
    static constexpr std::size_t kBlock = 64;
    static constexpr int kForStep = 5;
    static constexpr Duration kMaxRoundTrip{500'000'000};

    /// @return kInvalidArgument if the round trip is negative or too long, or the question not after the one before;
    ///         kCorrupt if the answer contradicts the offset: not used
    Status add(Timestamp sent, Timestamp received, Timestamp remote);

    /// The offset is known to 1 ms; stays so until a step.
    bool ready() const { return is_ready_; }
    /// Contract: ready().
    Timestamp to_remote(Timestamp own) const;
    /// The inverse. Contract: ready().
    Timestamp to_own(Timestamp remote) const;
    /// Forgets all, as after a step: somebody knows that the other side has restarted.
    void restart();
    /// Standard deviation of the offset at the last block; 0 before the first one.
    double sigma_s() const;
    double drift() const { return drift_; }
    std::uint64_t steps() const { return steps_; }

private:
    struct Exchange {
        Timestamp middle;  ///< own time
        double lower_s;    ///< bounds of the offset, beyond the base
        double upper_s;
    };

    bool contradicts(const Exchange& exchange) const;
    void finish_block();

    std::array<Exchange, kBlock> block_;
    std::size_t filled_ = 0;
    bool any_ = false;  ///< there is a base
    Timestamp last_sent_;
    std::int64_t base_ns_ = 0;  ///< remote - own of the first exchange: keeps the doubles below small
    bool is_running_ = false;   ///< there has been a block
    bool is_ready_ = false;
    int contradictions_ = 0;
    std::uint64_t steps_ = 0;
    Timestamp last_;         ///< own time of the last block
    double offset_s_ = 0.0;  ///< beyond the base, at last_
    double drift_ = 0.0;
    double p_oo_ = 0.0;  ///< covariance
    double p_od_ = 0.0;
    double p_dd_ = 0.0;
};

}  // namespace facet
