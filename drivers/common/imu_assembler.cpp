// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/common/imu_assembler.h"

namespace facet {

Status ImuAssembler::add_rate(Timestamp stamp, const Eigen::Vector3d& w_B) {
    if (!rate_order_.pass(stamp, counters_.out_of_order)) {
        return Status::kOutOfOrder;
    }
    if (!rates_.empty() && stamp < rates_.back().stamp) {
        rates_.clear();  // the clock was set back
    }
    counters_.overflowed += rates_.full() ? 1 : 0;
    rates_.push({stamp, w_B});
    return Status::kOk;
}

Status ImuAssembler::add_force(Timestamp stamp, const Eigen::Vector3d& a_B) {
    if (!force_order_.pass(stamp, counters_.out_of_order)) {
        return Status::kOutOfOrder;
    }
    if (!forces_.empty() && stamp < forces_.back().stamp) {
        forces_.clear();  // the clock was set back
    }
    forces_.push({stamp, a_B});
    return Status::kOk;
}

std::size_t ImuAssembler::force_at_or_after(Timestamp t) const {
    std::size_t i = 0;
    while (i < forces_.size() && forces_[i].stamp < t) {
        ++i;
    }
    return i;
}

Status ImuAssembler::pop(ImuSample& sample) {
    while (!rates_.empty()) {
        const Measurement rate = rates_.front();
        const std::size_t after = force_at_or_after(rate.stamp);
        if (after == forces_.size()) {
            return Status::kNotReady;
        }
        rates_.pop_front();
        const Measurement& b = forces_[after];
        if (b.stamp == rate.stamp) {
            sample = {rate.stamp, rate.value, b.value};
            forces_.pop_front(after);
            return Status::kOk;
        }
        if (after == 0 || b.stamp - forces_[after - 1].stamp > max_gap_) {
            ++counters_.unpaired;
            continue;
        }
        const Measurement& a = forces_[after - 1];
        const double part = (rate.stamp - a.stamp).seconds() / (b.stamp - a.stamp).seconds();
        sample = {rate.stamp, rate.value, a.value + part * (b.value - a.value)};
        forces_.pop_front(after - 1);  // a stays: the next rate may lie behind it too
        return Status::kOk;
    }
    return Status::kNotReady;
}

void ImuAssembler::clear() {
    rates_.clear();
    forces_.clear();
}

}  // namespace facet
