// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/ros2/imu_ros2.h"

#include <utility>

#include "drivers/common/stamp_fault.h"

namespace facet {
namespace {

constexpr double kMostForceInMessage_m_per_s2 = 1000.0;
constexpr double kMostRateInMessage_rad_per_s = 100.0;

/// @return what is wrong; nullptr if nothing is. NaN is too much of anything.
const char* fault_of(const Ros2Inertial& inertial) {
    if (!inertial.has_rates || !inertial.has_forces) {
        return "messages without angular velocity or without linear acceleration: a driver that publishes them apart "
               "has an option to unite them";
    }
    const bool is_possible =
        inertial.a.norm() < kMostForceInMessage_m_per_s2 && inertial.w.norm() < kMostRateInMessage_rad_per_s;
    return is_possible ? nullptr : "readings that cannot be";
}

}  // namespace

ImuRos2::ImuRos2(Ros2Node& node, const Clock& clock, ImuRos2Options options)
    : options_(std::move(options)),
      clock_(clock),
      reader_(node.imu_reader(options_.topic)),
      life_(*this, clock, options_.retry_period, counters_, options_.silence),
      order_(ClockDomain::kRealtime) {}

void ImuRos2::close() {
    lost_before_ += reader_->lost();
    reader_->close();
}

SourceCounters ImuRos2::counters() const {
    SourceCounters result = counters_;
    result.lost = lost_before_ + reader_->lost();
    return result;
}

Status ImuRos2::take(Duration timeout, ImuSample& sample) {
    Ros2Inertial inertial;
    const Status status = reader_->take(timeout, inertial);
    if (status == Status::kIo) {
        return life_.fail(options_.topic + ": the middleware fails");
    }
    FACET_TRY(status);
    if (const char* const fault = fault_of(inertial); fault != nullptr) {
        ++counters_.corrupt;
        life_.refuse(fault);
        return Status::kCorrupt;
    }
    const Timestamp stamp = inertial.stamp - options_.latency;
    const char* const fault = delivery_fault({inertial.stamp, stamp}, clock_, clock(), order_, counters_.discarded);
    if (fault != nullptr) {
        life_.refuse(fault);
        return Status::kNotReady;
    }
    order_.delivered(stamp);
    sample.stamp = stamp;
    sample.w_B = options_.axes.apply(inertial.w);
    sample.a_B = options_.axes.apply(inertial.a);
    return Status::kOk;
}

Status ImuRos2::next(Duration timeout, ImuSample& sample) {
    return life_.next(options_.topic, [&] { return take(timeout, sample); });
}

}  // namespace facet
