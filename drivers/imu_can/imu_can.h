// SPDX-License-Identifier: BSD-2-Clause
// An inertial sensor on a CAN bus.
#pragma once

#include <string>

#include "drivers/common/axis_map.h"
#include "drivers/common/imu_assembler.h"
#include "drivers/common/outage.h"
#include "drivers/common/retry_gate.h"
#include "drivers/imu_can/can_decoder.h"
#include "drivers/imu_can/can_socket.h"
#include "platform/port/imu_source.h"

namespace facet {

struct ImuCanOptions {
    CanSocketOptions socket;
    AxisMap axes;
    Duration latency;  ///< from measurement to the frame's reception stamp: bus, filter of the sensor; taken off
    Duration max_force_gap = Duration::from_seconds(0.05);  ///< see ImuAssembler
    Duration retry_period = Duration::from_seconds(0.5);
};

/// Counters beyond those of every source.
struct ImuCanCounters {
    std::uint64_t error_frames = 0;  ///< controller warnings, passive states, time-outs
    std::uint64_t bus_off = 0;       ///< times the controller left the bus
    std::uint64_t unstamped = 0;     ///< frames without a kernel time stamp: stamped on arrival here
    std::uint64_t overflows = 0;     ///< frames lost because the socket was full
};

/// Frames -> decoder -> ImuAssembler -> samples. After bus-off the controller is restarted by the kernel (`ip link set
/// can0 type can ... restart-ms 100`); the source says so in problem(), waits, and goes on with the first good frame. An
/// interface that goes down or away is reopened every retry period. Thread-bound. Heap in start() and for problem texts.
class ImuCan final : public ImuSource {
public:
    /// Everything is borrowed and must outlive the source.
    ImuCan(KernelIo& io, const Clock& clock, CanDecoder& decoder, ImuCanOptions options);

    Status start() override;
    void stop() override;
    Status next(Duration timeout, ImuSample& sample) override;
    ClockDomain clock() const override {
        return options_.socket.hardware_stamps ? ClockDomain::kHardware : ClockDomain::kRealtime;
    }
    SourceCounters counters() const override;
    std::string_view problem() const override { return outage_.problem; }
    double temperature_c() const override { return temperature_c_; }
    const ImuCanCounters& can_counters() const { return can_counters_; }

private:
    Status open();
    Status pop(ImuSample& sample);
    Status take(CanFrame& frame);
    Status take_error(const CanFrame& frame);
    Status fail(std::string problem);
    void recovered();

    const Clock& clock_;
    CanDecoder& decoder_;
    ImuCanOptions options_;
    CanSocket socket_;
    ImuAssembler assembler_;
    RetryGate retry_;
    SourceCounters counters_;
    ImuCanCounters can_counters_;
    Outage outage_;
    double temperature_c_ = std::numeric_limits<double>::quiet_NaN();
    Timestamp last_stamp_;
    bool any_delivered_ = false;
    bool started_ = false;
};

}  // namespace facet
