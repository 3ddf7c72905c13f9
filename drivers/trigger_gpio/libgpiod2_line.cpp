// SPDX-License-Identifier: BSD-2-Clause
// LibgpiodLine by the interface of libgpiod 2.x (Debian 13, Ubuntu 24.04).
#include <gpiod.h>

#include <cerrno>

#include "drivers/trigger_gpio/libgpiod_line.h"

namespace facet {
namespace {

/// The library's objects with the functions that free them.
template <auto kFree>
struct Freer {
    template <class T>
    void operator()(T* object) const {
        kFree(object);
    }
};
using Chip = std::unique_ptr<gpiod_chip, Freer<gpiod_chip_close>>;
using ChipInfo = std::unique_ptr<gpiod_chip_info, Freer<gpiod_chip_info_free>>;
using Settings = std::unique_ptr<gpiod_line_settings, Freer<gpiod_line_settings_free>>;
using LineConfig = std::unique_ptr<gpiod_line_config, Freer<gpiod_line_config_free>>;
using RequestConfig = std::unique_ptr<gpiod_request_config, Freer<gpiod_request_config_free>>;
using Request = std::unique_ptr<gpiod_line_request, Freer<gpiod_line_request_release>>;
using Events = std::unique_ptr<gpiod_edge_event_buffer, Freer<gpiod_edge_event_buffer_free>>;

Status find_line(gpiod_chip& chip, const GpioLineName& name, unsigned& offset, const std::string& label,
                 std::string& problem) {
    if (name.offset < 0) {
        const int found = gpiod_chip_get_line_offset_from_name(&chip, name.name.c_str());
        if (found < 0 && errno == ENOENT) {
            problem = label + ": no line has this name";
            return Status::kNotFound;
        }
        if (found < 0) {
            return gpio_problem(label, "the chip does not describe its lines", -errno, problem);
        }
        offset = static_cast<unsigned>(found);
        return Status::kOk;
    }
    offset = static_cast<unsigned>(name.offset);
    const ChipInfo info(gpiod_chip_get_info(&chip));
    if (!info) {
        return gpio_problem(label, "not a GPIO chip", -errno, problem);
    }
    const std::size_t lines = gpiod_chip_info_get_num_lines(info.get());
    if (offset >= lines) {
        problem = label + ": the chip has only " + std::to_string(lines) + " lines";
        return Status::kNotFound;
    }
    return Status::kOk;
}

gpiod_line_clock to_clock(ClockDomain clock) {
    return clock == ClockDomain::kRealtime   ? GPIOD_LINE_CLOCK_REALTIME
           : clock == ClockDomain::kHardware ? GPIOD_LINE_CLOCK_HTE
                                             : GPIOD_LINE_CLOCK_MONOTONIC;
}

/// -1 and errno if the library refuses a value.
int apply(const GpioInputSettings& input, gpiod_line_settings& settings) {
    const gpiod_line_edge edge = input.rising && input.falling ? GPIOD_LINE_EDGE_BOTH
                                 : input.falling               ? GPIOD_LINE_EDGE_FALLING
                                                               : GPIOD_LINE_EDGE_RISING;
    gpiod_line_settings_set_debounce_period_us(&settings, input.debounce_us);
    if (gpiod_line_settings_set_direction(&settings, GPIOD_LINE_DIRECTION_INPUT) != 0 ||
        gpiod_line_settings_set_edge_detection(&settings, edge) != 0 ||
        gpiod_line_settings_set_event_clock(&settings, to_clock(input.clock)) != 0) {
        return -1;
    }
    return input.pull_up ? gpiod_line_settings_set_bias(&settings, GPIOD_LINE_BIAS_PULL_UP) : 0;
}

Status request_line(const GpioLineName& name, gpiod_line_settings* settings, const std::string& label, Request& request,
                    unsigned& offset, std::string& problem) {
    const Chip chip(gpiod_chip_open(name.chip.c_str()));
    if (!chip) {
        return gpio_problem(label, "the chip cannot be opened", -errno, problem);
    }
    FACET_TRY(find_line(*chip, name, offset, label, problem));
    const LineConfig lines(gpiod_line_config_new());
    const RequestConfig config(gpiod_request_config_new());
    if (!lines || !config || settings == nullptr ||
        gpiod_line_config_add_line_settings(lines.get(), &offset, 1, settings) != 0) {
        return gpio_refusal(label, -errno, problem);
    }
    gpiod_request_config_set_consumer(config.get(), "facet");
    gpiod_request_config_set_event_buffer_size(config.get(), GpioLine::kEventsInKernel);
    request.reset(gpiod_chip_request_lines(chip.get(), config.get(), lines.get()));
    return request ? Status::kOk : gpio_refusal(label, -errno, problem);
}

}  // namespace

const bool LibgpiodLine::kNumbersEdges = true;

struct LibgpiodLine::Handle {
    Request request;
    unsigned offset = 0;
    Events events;
};

LibgpiodLine::LibgpiodLine() = default;
LibgpiodLine::~LibgpiodLine() = default;

void LibgpiodLine::close() {
    handle_.reset();
    fd_ = -1;
}

Status LibgpiodLine::open_input(const GpioLineName& name, const GpioInputSettings& input, std::string& problem) {
    close();
    label_ = describe(name);
    if (input.clock == ClockDomain::kDevice) {
        problem = label_ + ": edges cannot be stamped by a device's clock";
        return Status::kInvalidArgument;
    }
    auto handle = std::make_unique<Handle>();
    const Settings settings(gpiod_line_settings_new());
    handle->events.reset(gpiod_edge_event_buffer_new(kEventsPerRead));
    if (!settings || !handle->events || apply(input, *settings) != 0) {
        return gpio_refusal(label_, -errno, problem);
    }
    FACET_TRY(request_line(name, settings.get(), label_, handle->request, handle->offset, problem));
    handle_ = std::move(handle);
    fd_ = gpiod_line_request_get_fd(handle_->request.get());
    return Status::kOk;
}

Status LibgpiodLine::open_output(const GpioLineName& name, std::string& problem) {
    close();
    label_ = describe(name);
    auto handle = std::make_unique<Handle>();
    const Settings settings(gpiod_line_settings_new());
    if (!settings || gpiod_line_settings_set_direction(settings.get(), GPIOD_LINE_DIRECTION_OUTPUT) != 0) {
        return gpio_refusal(label_, -errno, problem);
    }
    FACET_TRY(request_line(name, settings.get(), label_, handle->request, handle->offset, problem));
    handle_ = std::move(handle);
    return Status::kOk;
}

Status LibgpiodLine::set(bool high, std::string& problem) {
    if (!handle_) {
        return gpio_problem(label_, "cannot be set", -EBADF, problem);
    }
    const gpiod_line_value value = high ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE;
    return gpiod_line_request_set_value(handle_->request.get(), handle_->offset, value) == 0
               ? Status::kOk
               : gpio_problem(label_, "cannot be set", -errno, problem);
}

int LibgpiodLine::read(std::span<GpioEvent, kEventsPerRead> events) {
    gpiod_edge_event_buffer* buffer = handle_->events.get();
    const int count = gpiod_line_request_read_edge_events(handle_->request.get(), buffer, kEventsPerRead);
    if (count < 0) {
        return -errno;
    }
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
        gpiod_edge_event* event = gpiod_edge_event_buffer_get_event(buffer, i);
        events[i] = {static_cast<std::int64_t>(gpiod_edge_event_get_timestamp_ns(event)),
                     static_cast<std::uint32_t>(gpiod_edge_event_get_line_seqno(event)),
                     gpiod_edge_event_get_event_type(event) == GPIOD_EDGE_EVENT_RISING_EDGE};
    }
    return count;
}

}  // namespace facet
