// SPDX-License-Identifier: BSD-2-Clause
// An inertial sensor that sends packets over a serial line.
#pragma once

#include <memory>
#include <string>

#include "drivers/common/axis_map.h"
#include "drivers/common/device_life.h"
#include "drivers/common/imu_assembler.h"
#include "drivers/imu_serial/packet_stream.h"
#include "platform/port/imu_source.h"
#include "platform/port/kernel_io.h"

namespace facet {

enum class SerialSensor : std::uint8_t { kVectorNav, kXsens, kMicroStrain };

struct ImuSerialOptions {
    SerialSensor sensor = SerialSensor::kVectorNav;
    std::string device = "/dev/ttyUSB0";
    int baud = 115200;  ///< what the three makers deliver
    AxisMap axes;
    Duration latency;                                       ///< of the sensor's filter; subtracted from the stamps
    Duration max_force_gap = Duration::from_seconds(0.05);  ///< see ImuAssembler
    Duration retry_period = Duration::from_seconds(0.5);
    Duration silence;  ///< without a sample for this long the line is opened again; zero: never
};

/// Bytes -> packets -> ImuAssembler -> samples in B, with the stamps of the sensor's own clock. Nothing is sent: which
/// outputs the sensor gives is set with its maker's program, and kept there. Thread-bound. Heap in the constructor and
/// for problem texts.
class ImuSerial final : public ImuSource, private Reopenable {
public:
    /// Everything is borrowed and must outlive the source.
    ImuSerial(KernelIo& io, Clock& clock, ImuSerialOptions options);
    ~ImuSerial() override { close(); }

    Status start() override { return life_.start(); }
    void stop() override { life_.stop(); }
    Status next(Duration timeout, ImuSample& sample) override;
    ClockDomain clock() const override { return ClockDomain::kDevice; }
    SourceCounters counters() const override;
    std::string_view problem() const override { return life_.problem(); }
    double temperature_c() const override { return temperature_c_; }

private:
    Status open(std::string& problem) override;
    void close() override;
    Status take_until(Timestamp deadline, ImuSample& sample);
    Status take_packet(std::span<const std::uint8_t> packet);
    Status receive(Timestamp deadline);
    Status lose(int error);

    KernelIo& io_;
    Clock& clock_;
    ImuSerialOptions options_;
    std::unique_ptr<SerialProtocol> protocol_;
    PacketStream stream_;
    ImuAssembler assembler_;
    SourceCounters counters_;
    DeviceLife life_;
    int fd_ = -1;
    double temperature_c_ = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace facet
