// SPDX-License-Identifier: BSD-2-Clause
// Which faults there are, when they hold, and how often they did something.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "app/lab/faults/fault.h"
#include "app/support/rng.h"

namespace facet {

/// The faults of a run with their counters. Thread-bound. Heap in the constructor only.
class FaultSchedule {
public:
    /// @param begin  instant from which the faults' times count
    FaultSchedule(std::vector<Fault> faults, Timestamp begin)
        : faults_(std::move(faults)), hits_(faults_.size(), 0), begin_(begin) {}

    const std::vector<Fault>& faults() const { return faults_; }
    /// For each fault, in order, the samples or frames it has changed or swallowed.
    const std::vector<std::size_t>& hits() const { return hits_; }
    /// Time on the faults' clock.
    Duration since_begin(Timestamp log_stamp) const { return log_stamp - begin_; }
    void count(std::size_t fault) { ++hits_.at(fault); }

    /// Calls apply(fault, index) for each fault of this kind that is active; it returns whether it did something.
    template <class Apply>
    void for_active(FaultKind kind, Timestamp log_stamp, Apply apply) {
        for (std::size_t i = 0; i < faults_.size(); ++i) {
            if (faults_[i].kind == kind && faults_[i].is_active(since_begin(log_stamp))) {
                hits_[i] += apply(faults_[i], i) ? 1 : 0;
            }
        }
    }

    /// The same for all faults that are there, active or not.
    template <class Apply>
    void for_all(FaultKind kind, Apply apply) const {
        for (std::size_t i = 0; i < faults_.size(); ++i) {
            if (faults_[i].kind == kind) {
                apply(faults_[i], i);
            }
        }
    }

    /// Whether one is active; counts it.
    bool is_active(FaultKind kind, Timestamp log_stamp) {
        bool found = false;
        for_active(kind, log_stamp, [&](const Fault&, std::size_t) { return found = true; });
        return found;
    }

    /// Sum of the SECONDS of the active ones.
    Duration shift(FaultKind kind, Timestamp log_stamp) {
        Duration sum;
        for_active(kind, log_stamp, [&](const Fault& fault, std::size_t) {
            sum = sum + Duration::from_seconds(fault.values[0]);
            return true;
        });
        return sum;
    }

    /// Random numbers of one fault at one sample.
    static RandomStream draws(FaultKind kind, std::size_t fault, std::uint64_t seed, std::uint64_t sample) {
        return {hash64(seed, static_cast<std::uint64_t>(kind), fault), sample};
    }

private:
    std::vector<Fault> faults_;
    std::vector<std::size_t> hits_;
    Timestamp begin_;
};

}  // namespace facet
