// SPDX-License-Identifier: BSD-2-Clause
// The pulses that make the cameras expose, where this computer makes them.
#pragma once

#include <memory>
#include <string>

#include "app/config/vehicle.h"
#include "drivers/trigger_gpio/trigger_output.h"
#include "platform/linux/linux_worker.h"

namespace facet {

/// A PWM, or a thread that moves a GPIO line. Thread-bound to its owner.
class PulseOutput {
public:
    /// Makes the driver; opens nothing. Kernel and clock are borrowed.
    PulseOutput(KernelIo& io, Clock& clock, const VehiclePulses& pulses);
    ~PulseOutput() { stop(); }
    PulseOutput(const PulseOutput&) = delete;
    PulseOutput& operator=(const PulseOutput&) = delete;

    /// @return what the system refused of the thread's options; empty if nothing
    /// Throws InputError if PWM or line cannot be used.
    std::string start(const ThreadOptions& thread);
    void stop();
    /// Why the pulses ended before stop(); empty if they did not. After stop().
    const std::string& problem() const { return problem_; }
    /// Pulses left out because the thread came too late; a PWM leaves out none.
    std::uint64_t skipped() const { return gpio_ ? gpio_->skipped() : 0; }

private:
    TriggerPulse pulse_;
    std::unique_ptr<PwmTrigger> pwm_;  ///< one of the two
    std::unique_ptr<GpioTriggerOutput> gpio_;
    std::string problem_;
    LinuxWorker worker_;
};

}  // namespace facet
