// SPDX-License-Identifier: BSD-2-Clause
// What LibgpiodLine uses of libgpiod 2's interface, for systems that have an older one: names, types and values as its
// documentation gives them.
#pragma once

#include <cstddef>
#include <cstdint>

// NOLINTBEGIN(readability-identifier-naming): names of the library
extern "C" {

struct gpiod_chip;
struct gpiod_chip_info;
struct gpiod_line_settings;
struct gpiod_line_config;
struct gpiod_request_config;
struct gpiod_line_request;
struct gpiod_edge_event;
struct gpiod_edge_event_buffer;

enum gpiod_line_value { GPIOD_LINE_VALUE_ERROR = -1, GPIOD_LINE_VALUE_INACTIVE = 0, GPIOD_LINE_VALUE_ACTIVE = 1 };
enum gpiod_line_direction { GPIOD_LINE_DIRECTION_AS_IS = 1, GPIOD_LINE_DIRECTION_INPUT, GPIOD_LINE_DIRECTION_OUTPUT };
enum gpiod_line_edge {
    GPIOD_LINE_EDGE_NONE = 1,
    GPIOD_LINE_EDGE_RISING,
    GPIOD_LINE_EDGE_FALLING,
    GPIOD_LINE_EDGE_BOTH
};
enum gpiod_line_bias {
    GPIOD_LINE_BIAS_AS_IS = 1,
    GPIOD_LINE_BIAS_UNKNOWN,
    GPIOD_LINE_BIAS_DISABLED,
    GPIOD_LINE_BIAS_PULL_UP,
    GPIOD_LINE_BIAS_PULL_DOWN
};
enum gpiod_line_clock { GPIOD_LINE_CLOCK_MONOTONIC = 1, GPIOD_LINE_CLOCK_REALTIME, GPIOD_LINE_CLOCK_HTE };
enum gpiod_edge_event_type { GPIOD_EDGE_EVENT_RISING_EDGE = 1, GPIOD_EDGE_EVENT_FALLING_EDGE };

gpiod_chip* gpiod_chip_open(const char* path);
void gpiod_chip_close(gpiod_chip* chip);
gpiod_chip_info* gpiod_chip_get_info(gpiod_chip* chip);
void gpiod_chip_info_free(gpiod_chip_info* info);
std::size_t gpiod_chip_info_get_num_lines(gpiod_chip_info* info);
int gpiod_chip_get_line_offset_from_name(gpiod_chip* chip, const char* name);
gpiod_line_request* gpiod_chip_request_lines(gpiod_chip* chip, gpiod_request_config* request, gpiod_line_config* lines);

gpiod_line_settings* gpiod_line_settings_new(void);
void gpiod_line_settings_free(gpiod_line_settings* settings);
int gpiod_line_settings_set_direction(gpiod_line_settings* settings, gpiod_line_direction direction);
int gpiod_line_settings_set_edge_detection(gpiod_line_settings* settings, gpiod_line_edge edge);
int gpiod_line_settings_set_bias(gpiod_line_settings* settings, gpiod_line_bias bias);
void gpiod_line_settings_set_debounce_period_us(gpiod_line_settings* settings, unsigned long period);
int gpiod_line_settings_set_event_clock(gpiod_line_settings* settings, gpiod_line_clock clock);

gpiod_line_config* gpiod_line_config_new(void);
void gpiod_line_config_free(gpiod_line_config* config);
int gpiod_line_config_add_line_settings(gpiod_line_config* config, const unsigned* offsets, std::size_t count,
                                        gpiod_line_settings* settings);

gpiod_request_config* gpiod_request_config_new(void);
void gpiod_request_config_free(gpiod_request_config* config);
void gpiod_request_config_set_consumer(gpiod_request_config* config, const char* consumer);
void gpiod_request_config_set_event_buffer_size(gpiod_request_config* config, std::size_t size);

void gpiod_line_request_release(gpiod_line_request* request);
int gpiod_line_request_set_value(gpiod_line_request* request, unsigned offset, gpiod_line_value value);
int gpiod_line_request_get_fd(gpiod_line_request* request);
int gpiod_line_request_read_edge_events(gpiod_line_request* request, gpiod_edge_event_buffer* buffer, std::size_t most);

gpiod_edge_event_buffer* gpiod_edge_event_buffer_new(std::size_t capacity);
void gpiod_edge_event_buffer_free(gpiod_edge_event_buffer* buffer);
gpiod_edge_event* gpiod_edge_event_buffer_get_event(gpiod_edge_event_buffer* buffer, unsigned long index);
gpiod_edge_event_type gpiod_edge_event_get_event_type(gpiod_edge_event* event);
std::uint64_t gpiod_edge_event_get_timestamp_ns(gpiod_edge_event* event);
unsigned long gpiod_edge_event_get_line_seqno(gpiod_edge_event* event);

}  // extern "C"
// NOLINTEND(readability-identifier-naming)
