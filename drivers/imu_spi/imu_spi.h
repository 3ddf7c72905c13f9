// SPDX-License-Identifier: BSD-2-Clause
// An inertial sensor on an SPI bus.
#pragma once

#include <string>

#include "drivers/common/axis_map.h"
#include "drivers/common/device_life.h"
#include "drivers/common/imu_assembler.h"
#include "drivers/imu_spi/spi_imu_chip.h"
#include "platform/port/imu_source.h"

namespace facet {

struct ImuSpiOptions {
    std::string name = "imu_spi";  ///< for problem()
    AxisMap axes;
    Duration latency;  ///< from measurement to data-ready edge (the chip's filter delay); subtracted from the stamps
    Duration poll_period = Duration::from_seconds(0.005);   ///< without a data-ready line
    Duration max_force_gap = Duration::from_seconds(0.05);  ///< see ImuAssembler
    Duration retry_period = Duration::from_seconds(0.2);    ///< an estimate stands still no longer than it has to
    Duration silence;      ///< without a sample for this long the chip is reset and set up again; zero: never
    int max_corrupt = 20;  ///< consecutive bad readings after which the chip is reset, as after a brown-out
};

/// Data-ready edges -> chip -> ImuAssembler -> samples in B. Without a data-ready line the chip is polled and samples
/// are stamped on arrival, which is good enough for bench tests only. Opening and reopening take a few hundred
/// milliseconds, also in next() with a zero timeout. Thread-bound. Heap in start() and for problem texts.
class ImuSpi final : public ImuSource, private Reopenable {
public:
    /// Everything is borrowed and must outlive the source. @param data_ready  nullptr to poll
    ImuSpi(SpiImuChip& chip, TriggerSource* data_ready, Clock& clock, ImuSpiOptions options);

    Status start() override;
    void stop() override;
    Status next(Duration timeout, ImuSample& sample) override;
    ClockDomain clock() const override {
        return data_ready_ == nullptr ? ClockDomain::kMonotonic : data_ready_->clock();
    }
    SourceCounters counters() const override;
    std::string_view problem() const override { return life_.problem(); }
    double temperature_c() const override { return temperature_c_; }

private:
    Status open(std::string& problem) override;
    void close() override { chip_.close(); }
    Status take_until(Timestamp deadline, ImuSample& sample);
    Status wait_for_edge(Timestamp deadline, TriggerEdge& edge);
    Status read(const TriggerEdge& edge);
    void take(const SpiMeasurement& measurement);
    Status fail(std::string_view problem);

    SpiImuChip& chip_;
    TriggerSource* data_ready_;
    Clock& clock_;
    ImuSpiOptions options_;
    ImuAssembler assembler_;
    SourceCounters counters_;
    DeviceLife life_;
    double temperature_c_ = std::numeric_limits<double>::quiet_NaN();
    Timestamp next_poll_;
    std::uint32_t polls_ = 0;
    int corrupt_in_a_row_ = 0;
};

}  // namespace facet
