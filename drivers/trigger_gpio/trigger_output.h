// SPDX-License-Identifier: BSD-2-Clause
// A periodic pulse that makes cameras expose.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "drivers/trigger_gpio/gpio_line.h"

namespace facet {

struct TriggerPulse {
    Duration period = Duration::from_seconds(0.05);
    Duration width = Duration::from_seconds(0.001);  ///< of the high level, below the period
};

/// Pulses made by a hardware PWM through sysfs (Documentation/driver-api/pwm.rst): no jitter, no thread. Thread-bound.
class PwmTrigger {
public:
    /// @param chip  such as /sys/class/pwm/pwmchip0
    PwmTrigger(KernelIo& io, std::string chip, int channel) : io_(io), chip_(std::move(chip)), channel_(channel) {}
    ~PwmTrigger() { stop(); }
    PwmTrigger(const PwmTrigger&) = delete;
    PwmTrigger& operator=(const PwmTrigger&) = delete;

    /// @return kInvalidArgument if the pulse is impossible, kNotFound if there is no such PWM, kIo if it refuses.
    Status start(const TriggerPulse& pulse, std::string& problem);
    void stop();
    /// No pulses for `pause`, after start(); they go on in a phase of their own.
    Status pause(Clock& clock, Duration pause, std::string& problem);

private:
    Status write(const std::string& file, std::int64_t value, std::string& problem);

    KernelIo& io_;
    std::string chip_;
    int channel_;
    bool running_ = false;
};

/// Pulses made by software on a GPIO line: as regular as the thread is scheduled, so wire the line back to an input
/// whose edges are stamped. Runs in a Worker. Thread-bound to it, except pulses().
class GpioTriggerOutput {
public:
    GpioTriggerOutput(KernelIo& io, Clock& clock, GpioLineName line)
        : clock_(clock), name_(std::move(line)), line_(make_gpio_line(name_.backend, io)) {}

    /// Requests the line, so that problems show before run(), which otherwise requests it itself.
    Status open(std::string& problem);

    /// Pulses until `stopping`, then releases the line. The n-th pulse rises at start + n * period, however late
    /// earlier ones were; a pulse that would be late by a period or more is skipped and counted.
    Status run(const TriggerPulse& pulse, const std::atomic<bool>& stopping, std::string& problem);

    /// Does not make the next pulse; the ones after it keep their instants. On any thread.
    void leave_out_next() { leaves_out_.store(true, std::memory_order_relaxed); }

    std::uint64_t pulses() const { return pulses_.load(std::memory_order_relaxed); }
    std::uint64_t skipped() const { return skipped_.load(std::memory_order_relaxed); }

private:
    Clock& clock_;
    GpioLineName name_;
    std::unique_ptr<GpioLine> line_;
    std::atomic<bool> leaves_out_{false};
    std::atomic<std::uint64_t> pulses_{0};
    std::atomic<std::uint64_t> skipped_{0};
};

}  // namespace facet
