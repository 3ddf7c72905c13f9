// SPDX-License-Identifier: BSD-2-Clause
// Edges of a GPIO line with the kernel's stamps: camera triggers, strobes, data-ready lines.
#pragma once

#include <string>

#include "drivers/common/outage.h"
#include "drivers/common/retry_gate.h"
#include "drivers/trigger_gpio/gpio_line.h"
#include "platform/base/ring_buffer.h"
#include "platform/port/trigger_source.h"

namespace facet {

struct TriggerGpioOptions {
    GpioLineName line;
    GpioInputSettings input;
    Duration retry_period = Duration::from_seconds(0.5);
};

/// The kernel stamps edges in the interrupt and counts them (line_seqno), also those that its buffer of 64 had no room
/// for: gaps are counted as lost. Thread-bound. Heap on failure only.
class TriggerGpio final : public TriggerSource {
public:
    static constexpr std::size_t kEventsARead = 16;

    /// Borrowed: io and clock (monotonic), which must outlive the source.
    TriggerGpio(KernelIo& io, const Clock& clock, TriggerGpioOptions options);

    Status start() override;
    void stop() override;
    Status next(Duration timeout, TriggerEdge& edge) override;
    ClockDomain clock() const override { return options_.input.clock; }
    SourceCounters counters() const override { return counters_; }
    std::string_view problem() const override { return outage_.problem; }

private:
    Status open();
    Status fail(std::string problem);
    Status read(Duration timeout);
    bool take(TriggerEdge& edge);

    KernelIo& io_;
    const Clock& clock_;
    TriggerGpioOptions options_;
    GpioLine line_;
    RetryGate retry_;
    RingBuffer<TriggerEdge, kEventsARead> waiting_;
    SourceCounters counters_;
    Outage outage_;
    std::uint32_t kernel_sequence_ = 0;  ///< of the last edge since the line was opened
    std::uint32_t base_ = 0;             ///< edges before that, so that the count goes on
    std::uint32_t last_sequence_ = 0;
    Timestamp last_stamp_;
    bool any_delivered_ = false;
    bool started_ = false;
};

}  // namespace facet
