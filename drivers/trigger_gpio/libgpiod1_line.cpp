// SPDX-License-Identifier: BSD-2-Clause
// LibgpiodLine by the interface of libgpiod 1.x (1.6.3 in Debian 12).
#include <gpiod.h>

#include <array>
#include <cerrno>

#include "drivers/trigger_gpio/libgpiod_line.h"

namespace facet {

const bool LibgpiodLine::kNumbersEdges = false;

struct LibgpiodLine::Handle {
    gpiod_chip* chip = nullptr;
    gpiod_line* line = nullptr;  ///< belongs to the chip, which releases it

    Handle() = default;
    ~Handle() {
        if (chip != nullptr) {
            gpiod_chip_close(chip);
        }
    }
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;

    Status find(const GpioLineName& name, const std::string& label, std::string& problem) {
        chip = gpiod_chip_open(name.chip.c_str());
        if (chip == nullptr) {
            return gpio_problem(label, "the chip cannot be opened", -errno, problem);
        }
        const unsigned lines = gpiod_chip_num_lines(chip);
        if (name.offset >= 0 && static_cast<unsigned>(name.offset) >= lines) {
            problem = label + ": the chip has only " + std::to_string(lines) + " lines";
            return Status::kNotFound;
        }
        line = name.offset >= 0 ? gpiod_chip_get_line(chip, static_cast<unsigned>(name.offset))
                                : gpiod_chip_find_line(chip, name.name.c_str());
        if (line != nullptr) {
            return Status::kOk;
        }
        if (name.offset < 0 && errno == ENOENT) {
            problem = label + ": no line has this name";
            return Status::kNotFound;
        }
        return gpio_problem(label, "the chip does not describe the line", -errno, problem);
    }

    Status request(int type, int flags, const std::string& label, std::string& problem) const {
        const gpiod_line_request_config config{"facet", type, flags};
        return gpiod_line_request(line, &config, 0) == 0 ? Status::kOk : gpio_refusal(label, -errno, problem);
    }
};

LibgpiodLine::LibgpiodLine() = default;
LibgpiodLine::~LibgpiodLine() = default;

void LibgpiodLine::close() {
    handle_.reset();
    fd_ = -1;
}

Status LibgpiodLine::open_input(const GpioLineName& name, const GpioInputSettings& settings, std::string& problem) {
    close();
    label_ = describe(name);
    if (settings.clock != ClockDomain::kMonotonic || settings.debounce_us > 0) {
        problem = label_ +
                  ": libgpiod 1 stamps edges by the monotonic clock and does not debounce: "
                  "use 'backend: chardev'";
        return Status::kInvalidArgument;
    }
    auto handle = std::make_unique<Handle>();
    FACET_TRY(handle->find(name, label_, problem));
    const int type = settings.rising && settings.falling ? GPIOD_LINE_REQUEST_EVENT_BOTH_EDGES
                     : settings.falling                  ? GPIOD_LINE_REQUEST_EVENT_FALLING_EDGE
                                                         : GPIOD_LINE_REQUEST_EVENT_RISING_EDGE;
    const int flags = settings.pull_up ? GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_UP : 0;
    FACET_TRY(handle->request(type, flags, label_, problem));
    handle_ = std::move(handle);
    fd_ = gpiod_line_event_get_fd(handle_->line);
    return Status::kOk;
}

Status LibgpiodLine::open_output(const GpioLineName& name, std::string& problem) {
    close();
    label_ = describe(name);
    auto handle = std::make_unique<Handle>();
    FACET_TRY(handle->find(name, label_, problem));
    FACET_TRY(handle->request(GPIOD_LINE_REQUEST_DIRECTION_OUTPUT, 0, label_, problem));
    handle_ = std::move(handle);
    return Status::kOk;
}

Status LibgpiodLine::set(bool high, std::string& problem) {
    if (!handle_) {
        return gpio_problem(label_, "cannot be set", -EBADF, problem);
    }
    return gpiod_line_set_value(handle_->line, high ? 1 : 0) == 0
               ? Status::kOk
               : gpio_problem(label_, "cannot be set", -errno, problem);
}

int LibgpiodLine::read(std::span<GpioEvent, kEventsPerRead> events) {
    std::array<gpiod_line_event, kEventsPerRead> raw{};
    const int count = gpiod_line_event_read_multiple(handle_->line, raw.data(), kEventsPerRead);
    if (count < 0) {
        return -errno;
    }
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
        events[i] = {raw[i].ts.tv_sec * 1'000'000'000LL + raw[i].ts.tv_nsec, 0,
                     raw[i].event_type == GPIOD_LINE_EVENT_RISING_EDGE};
    }
    return count;
}

}  // namespace facet
