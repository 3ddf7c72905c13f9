// SPDX-License-Identifier: BSD-2-Clause
// A GPIO chip without hardware, asked through the kernel's character device, or through a libgpiod of its own.
#pragma once

#include <linux/gpio.h>

#include <algorithm>
#include <cstring>
#include <deque>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "drivers/trigger_gpio/gpio_line.h"
#include "tests/support/fake_kernel.h"
#include "tests/support/scripted_source.h"

namespace facet::test {

/// What a line was requested as.
struct GpioRequest {
    std::uint32_t offset = 99;
    bool output = false;
    bool rising = false;
    bool falling = false;
    bool pull_up = false;
    ClockDomain clock = ClockDomain::kMonotonic;
    std::uint32_t debounce_us = 0;
    std::size_t room = 0;  ///< events that the kernel keeps

    bool operator==(const GpioRequest&) const = default;
};

/// A kernel with one GPIO chip of four lines, the third of which has a name, and with PWM files. fake_libgpiod1.cpp and
/// fake_libgpiod2.cpp are the library's functions on the chip constructed last.
class FakeGpio final : public FakeKernel {
public:
    static constexpr int kChip = 3;
    static constexpr int kLine = 4;
    static constexpr int kFile = 5;
    static constexpr unsigned kLines = 4;
    static constexpr const char* kPath = "/dev/gpiochip0";
    static constexpr std::uint64_t kFlagHte = 1ULL << 12;

    explicit FakeGpio(ManualClock& clock) : clock_(clock) { newest() = this; }
    static FakeGpio*& newest() {
        static FakeGpio* chip = nullptr;
        return chip;
    }

    bool present = true;
    bool busy = false;
    GpioRequest requested;
    int open_descriptors = 0;
    std::uint32_t sequence = 0;
    std::deque<GpioEvent> events;
    std::vector<std::pair<Timestamp, bool>> levels;
    std::vector<std::string> writes;
    std::map<std::string, int> refusals;
    std::function<void()> on_level = [] {};

    /// An edge is there once its stamp has passed. @param error_ns  of its stamp
    void edge(std::int64_t stamp_ns, bool rising = true, std::int64_t error_ns = 0) {
        clock_.sleep_until({stamp_ns});
        stamp_ns += error_ns;
        ++sequence;
        if (line_open_ && events.size() < requested.room) {
            events.push_back({stamp_ns, sequence, rising});
        }
    }

    static std::string name_of(unsigned offset) { return offset == 2 ? "CAM_TRIG" : ""; }
    bool has_chip(const std::string& path) const { return present && path == kPath; }
    /// @return 0 or -errno
    int request(const GpioRequest& request) {
        if (!present || busy) {
            return present ? -EBUSY : -ENODEV;
        }
        requested = request;
        line_open_ = true;
        sequence = 0;
        ++open_descriptors;
        return 0;
    }
    void release() {
        --open_descriptors;
        line_open_ = false;
        events.clear();
    }
    int set_level(bool high) {
        if (!present) {
            return -ENODEV;
        }
        levels.emplace_back(clock_.now(), high);
        on_level();
        return 0;
    }
    /// @return how many or -errno
    int take(std::size_t most, std::vector<GpioEvent>& taken) {
        if (!present) {
            return -ENODEV;
        }
        taken.clear();
        for (; taken.size() < most && !events.empty(); events.pop_front()) {
            taken.push_back(events.front());
        }
        return static_cast<int>(taken.size());
    }

    int open(const char* path, int) override {
        path_ = path;
        if (refusals.contains(path_)) {
            return refusals[path_];
        }
        const bool is_file = path_.starts_with("/sys/");
        if (!is_file && !has_chip(path_)) {
            return -ENOENT;
        }
        ++open_descriptors;
        return is_file ? kFile : kChip;
    }
    int close(int fd) override {
        if (fd == kLine) {
            release();
        } else {
            --open_descriptors;
        }
        return 0;
    }
    std::int64_t write(int, const void* buffer, std::size_t size) override {
        writes.push_back(path_ + "=" + std::string(static_cast<const char*>(buffer), size));
        return static_cast<std::int64_t>(size);
    }
    int ioctl(int fd, unsigned long number, void* argument) override {
        if (!present) {
            return -ENODEV;
        }
        if (number == GPIO_GET_CHIPINFO_IOCTL) {
            static_cast<gpiochip_info*>(argument)->lines = kLines;
            return 0;
        }
        if (number == GPIO_V2_GET_LINEINFO_IOCTL) {
            auto& info = *static_cast<gpio_v2_line_info*>(argument);
            std::strcpy(info.name, name_of(info.offset).c_str());
            return 0;
        }
        if (number == GPIO_V2_GET_LINE_IOCTL) {
            auto& line = *static_cast<gpio_v2_line_request*>(argument);
            line.fd = kLine;
            return request(decode(line));
        }
        if (number == GPIO_V2_LINE_SET_VALUES_IOCTL && fd == kLine) {
            return set_level((static_cast<gpio_v2_line_values*>(argument)->bits & 1) != 0);
        }
        return -ENOTTY;
    }
    int wait_readable(int, Duration timeout) override {
        if (!present || !events.empty()) {
            return 1;
        }
        clock_.advance(timeout);
        return 0;
    }
    std::int64_t read(int, void* buffer, std::size_t size) override {
        std::vector<GpioEvent> taken;
        const int count = take(size / sizeof(gpio_v2_line_event), taken);
        for (int i = 0; i < count; ++i) {
            const GpioEvent& from = taken[static_cast<std::size_t>(i)];
            gpio_v2_line_event event{};
            event.timestamp_ns = static_cast<std::uint64_t>(from.stamp_ns);
            event.id = from.rising ? GPIO_V2_LINE_EVENT_RISING_EDGE : GPIO_V2_LINE_EVENT_FALLING_EDGE;
            event.line_seqno = from.sequence;
            std::memcpy(static_cast<char*>(buffer) + static_cast<std::size_t>(i) * sizeof event, &event, sizeof event);
        }
        return count < 0 ? count
                         : static_cast<std::int64_t>(static_cast<std::size_t>(count) * sizeof(gpio_v2_line_event));
    }

private:
    static GpioRequest decode(const gpio_v2_line_request& line) {
        const std::uint64_t flags = line.config.flags;
        GpioRequest request;
        request.offset = line.offsets[0];
        request.output = (flags & GPIO_V2_LINE_FLAG_OUTPUT) != 0;
        request.rising = (flags & GPIO_V2_LINE_FLAG_EDGE_RISING) != 0;
        request.falling = (flags & GPIO_V2_LINE_FLAG_EDGE_FALLING) != 0;
        request.pull_up = (flags & GPIO_V2_LINE_FLAG_BIAS_PULL_UP) != 0;
        request.clock = (flags & kFlagHte) != 0                                 ? ClockDomain::kHardware
                        : (flags & GPIO_V2_LINE_FLAG_EVENT_CLOCK_REALTIME) != 0 ? ClockDomain::kRealtime
                                                                                : ClockDomain::kMonotonic;
        request.debounce_us = line.config.num_attrs == 1 ? line.config.attrs[0].attr.debounce_period_us : 0;
        request.room = line.event_buffer_size;
        return request;
    }

    ManualClock& clock_;
    bool line_open_ = false;
    std::string path_;
};

}  // namespace facet::test
