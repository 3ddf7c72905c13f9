// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/trigger_gpio/chardev_line.h"

#include <fcntl.h>
#include <linux/gpio.h>

#include <array>
#include <cerrno>
#include <cstring>

namespace facet {
namespace {

// The kernel's flags as numbers that combine; the last one is of kernels from 5.19 on, and older headers lack it.
constexpr std::uint64_t kFlagRising = GPIO_V2_LINE_FLAG_EDGE_RISING;
constexpr std::uint64_t kFlagFalling = GPIO_V2_LINE_FLAG_EDGE_FALLING;
constexpr std::uint64_t kFlagPullUp = GPIO_V2_LINE_FLAG_BIAS_PULL_UP;
constexpr std::uint64_t kFlagClockHte = 1ULL << 12;

}  // namespace

Status ChardevLine::find(int chip, const GpioLineName& name, std::uint32_t& offset, std::string& problem) {
    gpiochip_info info{};
    const int result = io_.ioctl(chip, GPIO_GET_CHIPINFO_IOCTL, &info);
    if (result < 0) {
        return gpio_problem(label_, "not a GPIO chip", result, problem);
    }
    if (name.offset >= 0) {
        offset = static_cast<std::uint32_t>(name.offset);
        if (offset < info.lines) {
            return Status::kOk;
        }
        problem = label_ + ": the chip has only " + std::to_string(info.lines) + " lines";
        return Status::kNotFound;
    }
    for (std::uint32_t i = 0; i < info.lines; ++i) {
        gpio_v2_line_info line{};
        line.offset = i;
        if (io_.ioctl(chip, GPIO_V2_GET_LINEINFO_IOCTL, &line) >= 0 &&
            name.name == std::string(line.name, strnlen(line.name, sizeof line.name))) {
            offset = i;
            return Status::kOk;
        }
    }
    problem = label_ + ": no line has this name";
    return Status::kNotFound;
}

Status ChardevLine::open(const GpioLineName& name, std::uint64_t flags, std::uint32_t debounce_us,
                         std::string& problem) {
    close();
    label_ = describe(name);
    const int chip = io_.open(name.chip.c_str(), O_RDWR);
    if (chip < 0) {
        return gpio_problem(label_, "the chip cannot be opened", chip, problem);
    }
    gpio_v2_line_request request{};
    Status status = find(chip, name, request.offsets[0], problem);
    if (ok(status)) {
        request.num_lines = 1;
        request.event_buffer_size = kEventsInKernel;
        request.config.flags = flags;
        std::memcpy(static_cast<char*>(request.consumer), "facet", 6);
        if (debounce_us > 0) {
            request.config.num_attrs = 1;
            request.config.attrs[0].mask = 1;
            request.config.attrs[0].attr.id = GPIO_V2_LINE_ATTR_ID_DEBOUNCE;
            request.config.attrs[0].attr.debounce_period_us = debounce_us;
        }
        const int result = io_.ioctl(chip, GPIO_V2_GET_LINE_IOCTL, &request);
        status = result < 0 ? gpio_refusal(label_, result, problem) : Status::kOk;
    }
    // The line has a descriptor of its own.
    (void)io_.close(chip);
    if (ok(status)) {
        fd_ = request.fd;
    }
    return status;
}

Status ChardevLine::open_input(const GpioLineName& name, const GpioInputSettings& settings, std::string& problem) {
    std::uint64_t flags = GPIO_V2_LINE_FLAG_INPUT;
    flags |= settings.rising ? kFlagRising : 0;
    flags |= settings.falling ? kFlagFalling : 0;
    flags |= settings.pull_up ? kFlagPullUp : 0;
    switch (settings.clock) {
        case ClockDomain::kMonotonic: break;
        case ClockDomain::kRealtime: flags |= GPIO_V2_LINE_FLAG_EVENT_CLOCK_REALTIME; break;
        case ClockDomain::kHardware: flags |= kFlagClockHte; break;
        case ClockDomain::kDevice:
            problem = describe(name) + ": edges cannot be stamped by a device's clock";
            return Status::kInvalidArgument;
    }
    return open(name, flags, settings.debounce_us, problem);
}

Status ChardevLine::open_output(const GpioLineName& name, std::string& problem) {
    return open(name, GPIO_V2_LINE_FLAG_OUTPUT, 0, problem);
}

Status ChardevLine::set(bool high, std::string& problem) {
    gpio_v2_line_values values{};
    values.bits = high ? 1 : 0;
    values.mask = 1;
    const int result = fd_ < 0 ? -EBADF : io_.ioctl(fd_, GPIO_V2_LINE_SET_VALUES_IOCTL, &values);
    return result < 0 ? gpio_problem(label_, "cannot be set", result, problem) : Status::kOk;
}

int ChardevLine::read(std::span<GpioEvent, kEventsPerRead> events) {
    std::array<gpio_v2_line_event, kEventsPerRead> raw{};
    const std::int64_t size = io_.read(fd_, raw.data(), sizeof raw);
    if (size < 0) {
        return static_cast<int>(size);
    }
    const std::size_t count = static_cast<std::size_t>(size) / sizeof(gpio_v2_line_event);
    for (std::size_t i = 0; i < count; ++i) {
        events[i] = {static_cast<std::int64_t>(raw[i].timestamp_ns), raw[i].line_seqno,
                     raw[i].id == GPIO_V2_LINE_EVENT_RISING_EDGE};
    }
    return static_cast<int>(count);
}

void ChardevLine::release() {
    if (fd_ >= 0) {
        (void)io_.close(fd_);
        fd_ = -1;
    }
}

}  // namespace facet
