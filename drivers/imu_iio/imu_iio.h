// SPDX-License-Identifier: BSD-2-Clause
// An inertial sensor that the kernel's industrial I/O drives.
#pragma once

#include <string>

#include "drivers/common/axis_map.h"
#include "drivers/common/device_life.h"
#include "drivers/common/imu_assembler.h"
#include "drivers/imu_iio/iio_device.h"
#include "platform/port/imu_source.h"

namespace facet {

/// What stamps are of.
enum class IioStamps : std::uint8_t {
    kKernel,   ///< the element `in_timestamp`: of the interrupt or of the sensor hub's report
    kArrival,  ///< the reading here, for devices without that element
};

struct ImuIioOptions {
    std::string gyro;   ///< name of the device of the angular rates
    std::string accel;  ///< of the specific forces; the same name: one device, one scan
    IioOptions device;
    IioStamps stamps = IioStamps::kKernel;
    AxisMap axes;                                           ///< after the mount matrix
    Duration latency;                                       ///< of the sensor's filter; subtracted from the stamps
    Duration max_force_gap = Duration::from_seconds(0.05);  ///< see ImuAssembler
    Duration retry_period = Duration::from_seconds(0.5);
    Duration silence;  ///< without a sample for this long the devices are reopened; zero: never
};

/// Scans of one device or two -> ImuAssembler -> samples in B. Stamps of the wall clock are brought onto the monotonic
/// one as they arrive. A device that has gone, as when a sensor hub is unplugged, is looked for by its name once every
/// retry period. Thread-bound. Heap in the constructor and for problem texts.
class ImuIio final : public ImuSource, private Reopenable {
public:
    /// Everything is borrowed and must outlive the source.
    ImuIio(KernelIo& io, Clock& clock, ImuIioOptions options);

    Status start() override { return life_.start(); }
    void stop() override { life_.stop(); }
    Status next(Duration timeout, ImuSample& sample) override;
    ClockDomain clock() const override { return ClockDomain::kMonotonic; }
    SourceCounters counters() const override;
    std::string_view problem() const override { return life_.problem(); }
    std::string_view warning() const override { return warning_; }
    double temperature_c() const override { return temperature_c_; }

    /// Scans stamped in the future or long ago: dropped, and among the discarded ones.
    std::uint64_t stamps_refused() const { return stamps_refused_; }

private:
    bool has_two() const { return options_.gyro != options_.accel; }
    Status open(std::string& problem) override;
    void close() override;
    void warn();
    Status take_until(Timestamp deadline, ImuSample& sample);
    Status take_from(IioDevice& device, bool& any);
    Status to_monotonic(const IioDevice& device, const IioScan& scan, Timestamp& stamp);
    Status wait(Timestamp deadline);
    Status lose(const IioDevice& device, int error);

    KernelIo& io_;
    Clock& clock_;
    ImuIioOptions options_;
    IioDevice first_;   ///< of the rates, or of both
    IioDevice second_;  ///< of the forces, if it is another one
    ImuAssembler assembler_;
    SourceCounters counters_;
    std::uint64_t stamps_refused_ = 0;
    DeviceLife life_;
    std::string warning_;
    double temperature_c_ = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace facet
