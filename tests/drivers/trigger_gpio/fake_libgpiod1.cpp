// SPDX-License-Identifier: BSD-2-Clause
// The functions of libgpiod 1.6 that LibgpiodLine calls, on a FakeGpio: they take the place of the library's own.
#include <gpiod.h>

#include <cerrno>

#include "tests/drivers/trigger_gpio/fake_gpio.h"

using facet::test::FakeGpio;
using facet::test::GpioRequest;

// NOLINTBEGIN(readability-identifier-naming): names of the library
struct gpiod_line {
    gpiod_chip* chip = nullptr;
    unsigned offset = 0;
    bool is_requested = false;
};
struct gpiod_chip {
    FakeGpio* gpio = nullptr;
    gpiod_line line;
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
    return new gpiod_chip{gpio, {}};
}

void gpiod_chip_close(gpiod_chip* chip) {
    if (chip->line.is_requested) {
        chip->gpio->release();
    }
    --chip->gpio->open_descriptors;
    delete chip;
}

unsigned gpiod_chip_num_lines(gpiod_chip*) { return FakeGpio::kLines; }

gpiod_line* gpiod_chip_get_line(gpiod_chip* chip, unsigned offset) {
    if (!chip->gpio->present || offset >= FakeGpio::kLines) {
        errno = chip->gpio->present ? EINVAL : ENODEV;
        return nullptr;
    }
    chip->line = {chip, offset, false};
    return &chip->line;
}

gpiod_line* gpiod_chip_find_line(gpiod_chip* chip, const char* name) {
    for (unsigned i = 0; i < FakeGpio::kLines; ++i) {
        if (FakeGpio::name_of(i) == name) {
            return gpiod_chip_get_line(chip, i);
        }
    }
    errno = ENOENT;
    return nullptr;
}

int gpiod_line_request(gpiod_line* line, const gpiod_line_request_config* config, int) {
    const int type = config->request_type;
    const bool both = type == GPIOD_LINE_REQUEST_EVENT_BOTH_EDGES;
    GpioRequest request;
    request.offset = line->offset;
    request.output = type == GPIOD_LINE_REQUEST_DIRECTION_OUTPUT;
    request.rising = both || type == GPIOD_LINE_REQUEST_EVENT_RISING_EDGE;
    request.falling = both || type == GPIOD_LINE_REQUEST_EVENT_FALLING_EDGE;
    request.pull_up = (config->flags & GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_UP) != 0;
    request.room = 16;  // of the kernel's first character device, which this library uses
    const int status = line->chip->gpio->request(request);
    line->is_requested = status == 0;
    return result_of(status);
}

int gpiod_line_event_get_fd(gpiod_line*) { return FakeGpio::kLine; }

int gpiod_line_event_read_multiple(gpiod_line* line, gpiod_line_event* events, unsigned most) {
    std::vector<facet::GpioEvent> taken;
    const int count = line->chip->gpio->take(most, taken);
    for (std::size_t i = 0; i < taken.size() && count > 0; ++i) {
        events[i].ts = {taken[i].stamp_ns / 1'000'000'000, taken[i].stamp_ns % 1'000'000'000};
        events[i].event_type = taken[i].rising ? GPIOD_LINE_EVENT_RISING_EDGE : GPIOD_LINE_EVENT_FALLING_EDGE;
    }
    return result_of(count);
}

int gpiod_line_set_value(gpiod_line* line, int value) { return result_of(line->chip->gpio->set_level(value != 0)); }

}  // extern "C"
// NOLINTEND(readability-identifier-naming)
