// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/trigger_gpio/trigger_gpio.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

namespace facet {

TriggerGpio::TriggerGpio(KernelIo& io, const Clock& clock, TriggerGpioOptions options)
    : io_(io),
      options_(std::move(options)),
      line_(make_gpio_line(options_.line.backend, io)),
      label_(describe(options_.line)),
      life_(*this, clock, options_.retry_period, counters_, options_.silence) {}

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
        if (!order_.pass(next.stamp, counters_.discarded)) {
            continue;  // two edges within the clock's resolution, or a clock that was set back
        }
        life_.works();
        last_sequence_ = next.sequence;
        ++counters_.delivered;
        edge = next;
        return true;
    }
    return false;
}

Status TriggerGpio::next(Duration timeout, TriggerEdge& edge) {
    FACET_TRY(life_.check());
    if (take(edge)) {
        return Status::kOk;
    }
    const Status status = read(timeout);
    if (ok(status) && take(edge)) {
        return Status::kOk;
    }
    return status == Status::kIo ? status : life_.not_ready(label_);
}

}  // namespace facet
