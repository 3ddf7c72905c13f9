// SPDX-License-Identifier: BSD-2-Clause
// The trigger pulses of the cameras, if this computer makes them.
#pragma once

#include <memory>
#include <string>

#include "app/config/vehicle.h"
#include "drivers/trigger_gpio/trigger_output.h"
#include "platform/linux/linux_worker.h"

namespace facet {

/// Drives a PWM, or a GPIO line by a thread of its own. Thread-bound to its owner.
class PulseOutput {
public:
    /// Constructs the driver; opens no device. Kernel and clock are borrowed.
    PulseOutput(KernelIo& io, Clock& clock, const VehiclePulses& pulses);
    ~PulseOutput() { stop(); }
    PulseOutput(const PulseOutput&) = delete;
    PulseOutput& operator=(const PulseOutput&) = delete;

    /// Throws InputError if PWM or line cannot be used.
    /// @return which of the thread's options the system refused; empty if none
    std::string start(const ThreadOptions& thread);
    void stop();
    /// Leaves one pulse out, as a proof of which frame belongs to which pulse: with a PWM by a pause of two periods.
    void leave_out_one();
    /// After stop(): why the pulses ended earlier; empty if they did not.
    const std::string& problem() const { return problem_; }
    /// Pulses skipped because the thread woke too late; a PWM skips none.
    std::uint64_t skipped() const { return gpio_ ? gpio_->skipped() : 0; }

private:
    Clock& clock_;
    TriggerPulse pulse_;
    std::unique_ptr<PwmTrigger> pwm_;  ///< one of the two
    std::unique_ptr<GpioTriggerOutput> gpio_;
    std::string problem_;
    LinuxWorker worker_;
};

}  // namespace facet
