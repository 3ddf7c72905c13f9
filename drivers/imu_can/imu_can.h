// SPDX-License-Identifier: BSD-2-Clause
// An inertial sensor on a CAN bus.
#pragma once

#include <string>

#include "drivers/common/axis_map.h"
#include "drivers/common/can_socket.h"
#include "drivers/common/device_life.h"
#include "drivers/common/imu_assembler.h"
#include "drivers/imu_can/can_decoder.h"
#include "platform/port/imu_source.h"

namespace facet {

struct ImuCanOptions {
    CanSocketOptions socket;
    AxisMap axes;
    /// From measurement to the frame's reception stamp (the sensor's filter, the bus); subtracted from the stamps.
    Duration latency;
    Duration max_force_gap = Duration::from_seconds(0.05);  ///< see ImuAssembler
    Duration retry_period = Duration::from_seconds(0.5);
    Duration silence;  ///< without a measurement for this long the socket is reopened; zero: never
};

/// Counters beyond those of every source.
struct ImuCanCounters {
    std::uint64_t error_frames = 0;  ///< controller warnings, error-passive states, timeouts
    std::uint64_t bus_off = 0;       ///< times the controller left the bus
    std::uint64_t unstamped = 0;     ///< frames without a kernel time stamp: stamped on arrival
    std::uint64_t stamps_refused =
        0;  ///< frames stamped after they were read, or long before, by a wall clock that was set: dropped
    std::uint64_t overflows = 0;  ///< frames lost because the socket was full
};

/// Frames -> decoder -> ImuAssembler -> samples. After bus-off the kernel restarts the controller (`ip link set can0
/// type can ... restart-ms 100`); the source reports that in problem(), waits, and continues with the first good frame.
/// SocketCAN stamps by the wall clock; each stamp is brought onto the monotonic clock as it arrives, so that steps of
/// the wall clock cost the frames that waited meanwhile and nothing else. Hardware stamps are passed on as they are.
/// If the interface goes down or disappears, the socket is reopened once every retry period. Thread-bound. Heap in
/// start() and for problem texts.
class ImuCan final : public ImuSource, private Reopenable {
public:
    /// Everything is borrowed and must outlive the source.
    ImuCan(KernelIo& io, const Clock& clock, CanDecoder& decoder, ImuCanOptions options);

    Status start() override { return life_.start(); }
    void stop() override { life_.stop(); }
    Status next(Duration timeout, ImuSample& sample) override;
    ClockDomain clock() const override {
        return options_.socket.hardware_stamps ? ClockDomain::kHardware : ClockDomain::kMonotonic;
    }
    SourceCounters counters() const override;
    std::string_view problem() const override { return life_.problem(); }
    double temperature_c() const override { return temperature_c_; }
    const ImuCanCounters& can_counters() const { return can_counters_; }

private:
    Status open(std::string& problem) override;
    void close() override { socket_.close(); }
    Status take_until(Timestamp deadline, ImuSample& sample);
    Status to_monotonic(Timestamp& stamp);
    Status take(CanFrame& frame);
    Status take_error(const CanFrame& frame);

    const Clock& clock_;
    CanDecoder& decoder_;
    ImuCanOptions options_;
    CanSocket socket_;
    ImuAssembler assembler_;
    SourceCounters counters_;
    ImuCanCounters can_counters_;
    DeviceLife life_;
    double temperature_c_ = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace facet
