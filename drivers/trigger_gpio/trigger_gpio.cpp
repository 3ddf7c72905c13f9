// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/trigger_gpio/trigger_gpio.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "drivers/common/stamp_fault.h"

namespace facet {

TriggerGpio::TriggerGpio(KernelIo& io, const Clock& clock, TriggerGpioOptions options)
    : io_(io),
      clock_(clock),
      options_(std::move(options)),
      line_(make_gpio_line(options_.line.backend, io)),
      label_(describe(options_.line)),
      life_(*this, clock, options_.retry_period, counters_, options_.silence),
      order_(options_.input.clock) {}

Status TriggerGpio::open(std::string& problem) {
    waiting_.clear();
    kernel_sequence_ = 0;
    base_ = last_sequence_;
    return line_->open_input(options_.line, options_.input, problem);
}

Status TriggerGpio::read(Duration timeout) {
    const int ready = io_.wait_readable(line_->fd(), timeout);
    if (ready == 0) {
        return Status::kNotReady;
    }
    std::array<GpioEvent, GpioLine::kEventsPerRead> events{};
    const int count = ready < 0 ? ready : line_->read(events);
    if (count == -EAGAIN || count == -EINTR) {
        return Status::kNotReady;
    }
    if (count <= 0) {
        return life_.fail(options_.line.chip + ": " + (count < 0 ? std::strerror(-count) : "closed"));
    }
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
        const GpioEvent& event = events[i];
        // The kernel counts from 1 when the line is requested. Without its numbers we count what arrives.
        const bool numbered = event.sequence != 0;
        const std::uint32_t sequence = numbered ? event.sequence : kernel_sequence_ + 1U;
        counters_.lost += sequence - kernel_sequence_ - 1U;
        kernel_sequence_ = sequence;
        waiting_.push({{event.stamp_ns}, base_ + sequence, event.rising, numbered});
    }
    return Status::kOk;
}

bool TriggerGpio::take(TriggerEdge& edge) {
    while (!waiting_.empty()) {
        const TriggerEdge next = waiting_.front();
        waiting_.pop_front();
        // Not increasing are also two edges within the clock's resolution.
        const char* const fault =
            delivery_fault({next.stamp, next.stamp}, clock_, options_.input.clock, order_, counters_.discarded);
        if (fault != nullptr) {
            life_.refuse(fault);
            continue;
        }
        order_.delivered(next.stamp);
        last_sequence_ = next.sequence;
        edge = next;
        return true;
    }
    return false;
}

Status TriggerGpio::next(Duration timeout, TriggerEdge& edge) {
    return life_.next(label_, [&] {
        if (take(edge)) {
            return Status::kOk;
        }
        FACET_TRY(read(timeout));
        return take(edge) ? Status::kOk : Status::kNotReady;
    });
}

}  // namespace facet
