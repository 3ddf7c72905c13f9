// SPDX-License-Identifier: BSD-2-Clause
// The functions of libgpiod 2 that LibgpiodLine calls, on a FakeGpio: they take the place of the library's own.
#include <gpiod.h>

#include <cerrno>

#include "tests/drivers/trigger_gpio/fake_gpio.h"

using facet::ClockDomain;
using facet::test::FakeGpio;
using facet::test::GpioRequest;

// NOLINTBEGIN(readability-identifier-naming): names of the library
struct gpiod_chip {
    FakeGpio* gpio = nullptr;
};
struct gpiod_chip_info {};
struct gpiod_line_settings {
    GpioRequest request;
};
struct gpiod_line_config {
    GpioRequest request;
};
struct gpiod_request_config {
    std::size_t room = 16;
};
struct gpiod_line_request {
    FakeGpio* gpio = nullptr;
};
struct gpiod_edge_event {
    facet::GpioEvent event;
};
struct gpiod_edge_event_buffer {
    std::vector<gpiod_edge_event> events;
};

namespace {

int result_of(int status) {
    errno = status < 0 ? -status : errno;
    return status < 0 ? -1 : status;
}

}  // namespace

extern "C" {

gpiod_chip* gpiod_chip_open(const char* path) {
    FakeGpio* gpio = FakeGpio::newest();
    if (!gpio->has_chip(path)) {
        errno = ENOENT;
        return nullptr;
    }
    ++gpio->open_descriptors;
    return new gpiod_chip{gpio};
}

void gpiod_chip_close(gpiod_chip* chip) {
    --chip->gpio->open_descriptors;
    delete chip;
}

gpiod_chip_info* gpiod_chip_get_info(gpiod_chip*) { return new gpiod_chip_info; }
void gpiod_chip_info_free(gpiod_chip_info* info) { delete info; }
std::size_t gpiod_chip_info_get_num_lines(gpiod_chip_info*) { return FakeGpio::kLines; }

int gpiod_chip_get_line_offset_from_name(gpiod_chip*, const char* name) {
    for (unsigned i = 0; i < FakeGpio::kLines; ++i) {
        if (FakeGpio::name_of(i) == name) {
            return static_cast<int>(i);
        }
    }
    return result_of(-ENOENT);
}

gpiod_line_request* gpiod_chip_request_lines(gpiod_chip* chip, gpiod_request_config* config, gpiod_line_config* lines) {
    GpioRequest request = lines->request;
    request.room = config->room;
    return result_of(chip->gpio->request(request)) < 0 ? nullptr : new gpiod_line_request{chip->gpio};
}

gpiod_line_settings* gpiod_line_settings_new() { return new gpiod_line_settings; }
void gpiod_line_settings_free(gpiod_line_settings* settings) { delete settings; }
int gpiod_line_settings_set_direction(gpiod_line_settings* settings, gpiod_line_direction direction) {
    settings->request.output = direction == GPIOD_LINE_DIRECTION_OUTPUT;
    return 0;
}
int gpiod_line_settings_set_edge_detection(gpiod_line_settings* settings, gpiod_line_edge edge) {
    settings->request.rising = edge == GPIOD_LINE_EDGE_RISING || edge == GPIOD_LINE_EDGE_BOTH;
    settings->request.falling = edge == GPIOD_LINE_EDGE_FALLING || edge == GPIOD_LINE_EDGE_BOTH;
    return 0;
}
int gpiod_line_settings_set_bias(gpiod_line_settings* settings, gpiod_line_bias bias) {
    settings->request.pull_up = bias == GPIOD_LINE_BIAS_PULL_UP;
    return 0;
}
void gpiod_line_settings_set_debounce_period_us(gpiod_line_settings* settings, unsigned long period) {
    settings->request.debounce_us = static_cast<std::uint32_t>(period);
}
int gpiod_line_settings_set_event_clock(gpiod_line_settings* settings, gpiod_line_clock clock) {
    settings->request.clock = clock == GPIOD_LINE_CLOCK_HTE        ? ClockDomain::kHardware
                              : clock == GPIOD_LINE_CLOCK_REALTIME ? ClockDomain::kRealtime
                                                                   : ClockDomain::kMonotonic;
    return 0;
}

gpiod_line_config* gpiod_line_config_new() { return new gpiod_line_config; }
void gpiod_line_config_free(gpiod_line_config* config) { delete config; }
int gpiod_line_config_add_line_settings(gpiod_line_config* config, const unsigned* offsets, std::size_t count,
                                        gpiod_line_settings* settings) {
    config->request = settings->request;
    config->request.offset = offsets[0];
    return result_of(count == 1 ? 0 : -EINVAL);
}

gpiod_request_config* gpiod_request_config_new() { return new gpiod_request_config; }
void gpiod_request_config_free(gpiod_request_config* config) { delete config; }
void gpiod_request_config_set_consumer(gpiod_request_config*, const char*) {}
void gpiod_request_config_set_event_buffer_size(gpiod_request_config* config, std::size_t size) { config->room = size; }

void gpiod_line_request_release(gpiod_line_request* request) {
    request->gpio->release();
    delete request;
}
int gpiod_line_request_set_value(gpiod_line_request* request, unsigned, gpiod_line_value value) {
    return result_of(request->gpio->set_level(value == GPIOD_LINE_VALUE_ACTIVE));
}
int gpiod_line_request_get_fd(gpiod_line_request*) { return FakeGpio::kLine; }
int gpiod_line_request_read_edge_events(gpiod_line_request* request, gpiod_edge_event_buffer* buffer,
                                        std::size_t most) {
    std::vector<facet::GpioEvent> taken;
    const int count = request->gpio->take(most, taken);
    buffer->events.clear();
    for (const facet::GpioEvent& event : taken) {
        buffer->events.push_back({event});
    }
    return result_of(count);
}

gpiod_edge_event_buffer* gpiod_edge_event_buffer_new(std::size_t) { return new gpiod_edge_event_buffer; }
void gpiod_edge_event_buffer_free(gpiod_edge_event_buffer* buffer) { delete buffer; }
gpiod_edge_event* gpiod_edge_event_buffer_get_event(gpiod_edge_event_buffer* buffer, unsigned long index) {
    return &buffer->events.at(index);
}
gpiod_edge_event_type gpiod_edge_event_get_event_type(gpiod_edge_event* event) {
    return event->event.rising ? GPIOD_EDGE_EVENT_RISING_EDGE : GPIOD_EDGE_EVENT_FALLING_EDGE;
}
std::uint64_t gpiod_edge_event_get_timestamp_ns(gpiod_edge_event* event) {
    return static_cast<std::uint64_t>(event->event.stamp_ns);
}
unsigned long gpiod_edge_event_get_line_seqno(gpiod_edge_event* event) { return event->event.sequence; }

}  // extern "C"
// NOLINTEND(readability-identifier-naming)
