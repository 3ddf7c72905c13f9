// SPDX-License-Identifier: BSD-2-Clause
// An inertial sensor on an SPI bus.
#pragma once

#include <string>

#include "drivers/common/axis_map.h"
#include "drivers/common/imu_assembler.h"
#include "drivers/common/outage.h"
#include "drivers/common/retry_gate.h"
#include "drivers/imu_spi/spi_imu_chip.h"
#include "platform/port/imu_source.h"

namespace facet {

struct ImuSpiOptions {
    std::string name = "imu_spi";  ///< for problem()
    AxisMap axes;
    Duration latency;  ///< from measurement to data-ready edge: the chip's filter delay; taken off
    Duration poll_period = Duration::from_seconds(0.005);   ///< without a data-ready line
    Duration max_force_gap = Duration::from_seconds(0.05);  ///< see ImuAssembler
    Duration retry_period = Duration::from_seconds(0.5);
    int max_corrupt = 20;  ///< bad reads in a row after which the chip is reset, as after a brown-out
};

/// Data-ready edges -> chip -> ImuAssembler -> samples in B. Without a data-ready line the chip is polled and stamped on
/// arrival, which is only good for tests on the bench. Opening and reopening take a few hundred milliseconds, also in
/// next() with a zero timeout. Thread-bound. Heap in start() and for problem texts.
class ImuSpi final : public ImuSource {
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
    std::string_view problem() const override { return outage_.problem; }
    double temperature_c() const override { return temperature_c_; }

private:
    Status open();
    Status pop(ImuSample& sample);
    Status wait_for_edge(Timestamp deadline, TriggerEdge& edge);
    Status read(const TriggerEdge& edge);
    void take(const SpiMeasurement& measurement);
    Status fail(std::string problem);

    SpiImuChip& chip_;
    TriggerSource* data_ready_;
    Clock& clock_;
    ImuSpiOptions options_;
    ImuAssembler assembler_;
    RetryGate retry_;
    SourceCounters counters_;
    Outage outage_;
    double temperature_c_ = std::numeric_limits<double>::quiet_NaN();
    Timestamp last_stamp_;
    Timestamp next_poll_;
    std::uint32_t polls_ = 0;
    int corrupt_in_a_row_ = 0;
    bool any_delivered_ = false;
    bool started_ = false;
    bool open_ = false;
    bool tested_ = false;  ///< since start(): a chip opened again in flight is not tested again
};

}  // namespace facet
