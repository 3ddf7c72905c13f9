// SPDX-License-Identifier: BSD-2-Clause
// Edges of a GPIO line with the kernel's stamps: camera triggers, strobes, data-ready lines.
#pragma once

#include <memory>
#include <string>

#include "drivers/common/device_life.h"
#include "drivers/common/increasing_stamps.h"
#include "drivers/trigger_gpio/gpio_line.h"
#include "platform/base/ring_buffer.h"
#include "platform/port/trigger_source.h"

namespace facet {

struct TriggerGpioOptions {
    GpioLineName line;
    GpioInputSettings input;
    Duration retry_period = Duration::from_seconds(0.5);
    Duration silence{};  ///< without an edge for this long the line is requested again; zero: never
};

/// The kernel stamps edges in the interrupt and numbers them (line_seqno), including those that did not fit into its
/// buffer: gaps are counted as lost. Where the numbers do not reach us (libgpiod 1.6), edges that arrive are counted,
/// and TriggerEdge::numbered says so. Thread-bound. Heap when the line is opened and on failure only.
class TriggerGpio final : public TriggerSource, private Reopenable {
public:
    /// Borrowed: io and clock (monotonic), which must outlive the source.
    TriggerGpio(KernelIo& io, const Clock& clock, TriggerGpioOptions options);

    Status start() override { return life_.start(); }
    void stop() override { life_.stop(); }
    Status next(Duration timeout, TriggerEdge& edge) override;
    ClockDomain clock() const override { return options_.input.clock; }
    SourceCounters counters() const override { return counters_; }
    std::string_view problem() const override { return life_.problem(); }

private:
    Status open(std::string& problem) override;
    void close() override { line_->close(); }
    Status read(Duration timeout);
    bool take(TriggerEdge& edge);

    KernelIo& io_;
    const Clock& clock_;
    TriggerGpioOptions options_;
    std::unique_ptr<GpioLine> line_;
    RingBuffer<TriggerEdge, GpioLine::kEventsPerRead> waiting_;
    SourceCounters counters_;
    std::string label_;
    DeviceLife life_;
    IncreasingStamps order_;
    std::uint32_t kernel_sequence_ = 0;  ///< of the last edge since the line was opened
    std::uint32_t base_ = 0;             ///< edges before the line was opened, so that the count continues
    std::uint32_t last_sequence_ = 0;
};

}  // namespace facet
