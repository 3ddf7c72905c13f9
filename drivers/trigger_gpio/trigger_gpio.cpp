// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/trigger_gpio/trigger_gpio.h"

#include <linux/gpio.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

namespace facet {

TriggerGpio::TriggerGpio(KernelIo& io, const Clock& clock, TriggerGpioOptions options)
    : io_(io), options_(std::move(options)), line_(io), life_(*this, clock, options_.retry_period, counters_) {}

Status TriggerGpio::open(std::string& problem) {
    waiting_.clear();
    kernel_sequence_ = 0;
    base_ = last_sequence_;
    return line_.open_input(options_.line, options_.input, problem);
}

Status TriggerGpio::read(Duration timeout) {
    const int ready = io_.wait_readable(line_.fd(), timeout);
    if (ready == 0) {
        return Status::kNotReady;
    }
    std::array<gpio_v2_line_event, kEventsPerRead> events{};
    const std::int64_t size = ready < 0 ? ready : io_.read(line_.fd(), events.data(), sizeof events);
    if (size == -EAGAIN) {
        return Status::kNotReady;
    }
    if (size <= 0) {
        return life_.fail(options_.line.chip + ": " + (size < 0 ? std::strerror(static_cast<int>(-size)) : "closed"));
    }
    for (std::size_t i = 0; i < static_cast<std::size_t>(size) / sizeof(gpio_v2_line_event); ++i) {
        const gpio_v2_line_event& event = events[i];
        // The kernel counts from 1 when the line is requested.
        counters_.lost += event.line_seqno - kernel_sequence_ - 1U;
        kernel_sequence_ = event.line_seqno;
        waiting_.push({{static_cast<std::int64_t>(event.timestamp_ns)},
                       base_ + event.line_seqno,
                       event.id == GPIO_V2_LINE_EVENT_RISING_EDGE});
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
    FACET_TRY(read(timeout));
    return take(edge) ? Status::kOk : Status::kNotReady;
}

}  // namespace facet
