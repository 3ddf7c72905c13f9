// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/trigger_gpio/trigger_output.h"

#include <fcntl.h>

#include <cerrno>
#include <cstring>

namespace facet {
namespace {

bool is_possible(const TriggerPulse& pulse) {
    return pulse.width.ns > 0 && pulse.period > pulse.width && pulse.period <= Duration::from_seconds(10.0);
}

}  // namespace

Status PwmTrigger::write(const std::string& file, std::int64_t value, std::string& problem) {
    const int fd = io_.open(file.c_str(), O_WRONLY);
    std::int64_t result = fd;
    if (fd >= 0) {
        const std::string text = std::to_string(value);
        result = io_.write(fd, text.data(), text.size());
        (void)io_.close(fd);
    }
    if (result >= 0) {
        return Status::kOk;
    }
    problem = file + ": " + std::strerror(static_cast<int>(-result));
    return result == -ENOENT || result == -ENODEV ? Status::kNotFound : Status::kIo;
}

Status PwmTrigger::start(const TriggerPulse& pulse, std::string& problem) {
    if (!is_possible(pulse)) {
        problem = "trigger: the pulse must be shorter than its period, and the period at most 10 s";
        return Status::kInvalidArgument;
    }
    // Busy means that it is exported already.
    std::string export_problem;
    const Status exported = write(chip_ + "/export", channel_, export_problem);
    const std::string folder = chip_ + "/pwm" + std::to_string(channel_);
    if (exported == Status::kNotFound) {
        problem = export_problem;
        return exported;
    }
    // The duty cycle must never exceed the period on the way.
    FACET_TRY(write(folder + "/duty_cycle", 0, problem));
    FACET_TRY(write(folder + "/period", pulse.period.ns, problem));
    FACET_TRY(write(folder + "/duty_cycle", pulse.width.ns, problem));
    FACET_TRY(write(folder + "/enable", 1, problem));
    running_ = true;
    return Status::kOk;
}

void PwmTrigger::stop() {
    if (running_) {
        std::string ignored;
        (void)write(chip_ + "/pwm" + std::to_string(channel_) + "/enable", 0, ignored);
        running_ = false;
    }
}

Status PwmTrigger::pause(Clock& clock, Duration pause, std::string& problem) {
    const std::string enable = chip_ + "/pwm" + std::to_string(channel_) + "/enable";
    FACET_TRY(write(enable, 0, problem));
    clock.sleep(pause);
    return write(enable, 1, problem);
}

Status GpioTriggerOutput::open(std::string& problem) {
    return line_->is_open() ? Status::kOk : line_->open_output(name_, problem);
}

Status GpioTriggerOutput::run(const TriggerPulse& pulse, const std::atomic<bool>& stopping, std::string& problem) {
    if (!is_possible(pulse)) {
        problem = "trigger: the pulse must be shorter than its period, and the period at most 10 s";
        return Status::kInvalidArgument;
    }
    FACET_TRY(open(problem));
    Status status = Status::kOk;
    Timestamp rise = clock_.now();
    while (ok(status) && !stopping.load(std::memory_order_relaxed)) {
        clock_.sleep_until(rise);
        const Duration late = clock_.now() - rise;
        if (late >= pulse.period) {
            const std::int64_t periods = late.ns / pulse.period.ns;
            skipped_.fetch_add(static_cast<std::uint64_t>(periods), std::memory_order_relaxed);
            rise = rise + Duration{periods * pulse.period.ns};
        }
        if (leaves_out_.exchange(false, std::memory_order_relaxed)) {
            rise = rise + pulse.period;
            continue;
        }
        status = line_->set(true, problem);
        if (ok(status)) {
            clock_.sleep_until(clock_.now() + pulse.width);
            status = line_->set(false, problem);
            pulses_.fetch_add(1, std::memory_order_relaxed);
        }
        rise = rise + pulse.period;
    }
    line_->close();
    return status;
}

}  // namespace facet
