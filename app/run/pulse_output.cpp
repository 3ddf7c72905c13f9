// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/pulse_output.h"

#include <fmt/core.h>

#include <stdexcept>

#include "app/support/input_error.h"

namespace facet {

PulseOutput::PulseOutput(KernelIo& io, Clock& clock, const VehiclePulses& pulses)
    : clock_(clock), pulse_(pulses.pulse) {
    if (pulses.pwm_chip.empty()) {
        gpio_ = std::make_unique<GpioTriggerOutput>(io, clock, pulses.line);
    } else {
        pwm_ = std::make_unique<PwmTrigger>(io, pulses.pwm_chip, pulses.pwm_channel);
    }
}

std::string PulseOutput::start(const ThreadOptions& thread) {
    std::string problem;
    if (!ok(pwm_ ? pwm_->start(pulse_, problem) : gpio_->open(problem))) {
        throw InputError("trigger_output: " + problem);
    }
    WorkerReport report;
    if (gpio_) {
        const Status started = worker_.start(
            {"facet-pulses", thread.cpu, thread.priority},
            [this](const std::atomic<bool>& stopping) {
                std::string words;
                if (!ok(gpio_->run(pulse_, stopping, words))) {
                    problem_ = "trigger_output: " + words;
                }
            },
            report);
        if (!ok(started)) {
            throw std::runtime_error(fmt::format("thread facet-pulses: {}", to_string(started)));
        }
    }
    return report.refusals;
}

void PulseOutput::leave_out_one() {
    if (gpio_) {
        gpio_->leave_out_next();
        return;
    }
    // If the pulses cannot go on, the missing edges say so.
    (void)pwm_->pause(clock_, Duration{2 * pulse_.period.ns}, problem_);
}

void PulseOutput::stop() {
    worker_.request_stop();
    worker_.join();
    if (pwm_) {
        pwm_->stop();
    }
}

}  // namespace facet
