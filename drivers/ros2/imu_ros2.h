// SPDX-License-Identifier: BSD-2-Clause
// An inertial sensor whose driver publishes on a ROS 2 topic.
#pragma once

#include <memory>
#include <string>

#include "drivers/common/axis_map.h"
#include "drivers/common/device_life.h"
#include "drivers/common/increasing_stamps.h"
#include "drivers/ros2/ros2_node.h"
#include "platform/port/imu_source.h"

namespace facet {

struct ImuRos2Options {
    std::string topic;  ///< of sensor_msgs/Imu, as ROS 2 names it
    AxisMap axes;       ///< from the message's frame to the body
    Duration latency;   ///< from measurement to stamp; subtracted from the stamps
    Duration retry_period = Duration::from_seconds(0.5);
    Duration silence;  ///< without a sample for this long the topic is subscribed to again; zero: never
};

/// Rates and specific forces of one message are one sample at the stamp of its header, less the latency. A message is
/// corrupt that says it lacks one of them (first element of their covariance -1), or whose numbers cannot be.
/// Thread-bound. Heap in start(), in the middleware and for problem texts.
class ImuRos2 final : public ImuSource, private Reopenable {
public:
    /// Borrowed: node and clock, which must outlive the source.
    ImuRos2(Ros2Node& node, const Clock& clock, ImuRos2Options options);

    Status start() override { return life_.start(); }
    void stop() override { life_.stop(); }
    Status next(Duration timeout, ImuSample& sample) override;
    ClockDomain clock() const override { return ClockDomain::kRealtime; }
    SourceCounters counters() const override;
    std::string_view problem() const override { return life_.problem(); }

private:
    Status open(std::string& problem) override { return reader_->open(problem); }
    void close() override;
    Status take(Duration timeout, ImuSample& sample);

    ImuRos2Options options_;
    const Clock& clock_;
    std::unique_ptr<Ros2Reader<Ros2Inertial>> reader_;
    SourceCounters counters_;
    DeviceLife life_;
    IncreasingStamps order_;
    std::uint64_t lost_before_ = 0;  ///< by readers that were closed
};

}  // namespace facet
