// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/trigger_gpio/trigger_gpio.h"

#include <linux/gpio.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <deque>
#include <map>
#include <vector>

#include "drivers/trigger_gpio/trigger_output.h"
#include "tests/port_conformance/source_conformance.h"
#include "tests/support/fake_kernel.h"
#include "tests/support/scripted_source.h"

namespace facet {
namespace {

/// A kernel with one GPIO chip of four lines, and PWM files.
class FakeGpio final : public test::FakeKernel {
public:
    static constexpr int kChip = 3;
    static constexpr int kLine = 4;
    static constexpr int kFile = 5;

    explicit FakeGpio(ManualClock& clock) : clock_(clock) {}

    bool present = true;
    bool busy = false;
    std::uint64_t flags = 0;
    std::uint32_t debounce_us = 0;
    std::uint32_t offset = 99;
    int open_descriptors = 0;
    std::uint32_t sequence = 0;
    std::deque<gpio_v2_line_event> events;
    std::vector<std::pair<Timestamp, bool>> levels;
    std::vector<std::string> writes;
    std::map<std::string, int> refusals;
    std::function<void()> on_level = [] {};

    void edge(std::int64_t stamp_ns, bool rising = true) {
        ++sequence;
        if (line_open_ && events.size() < 64) {
            gpio_v2_line_event event{};
            event.timestamp_ns = static_cast<std::uint64_t>(stamp_ns);
            event.id = rising ? GPIO_V2_LINE_EVENT_RISING_EDGE : GPIO_V2_LINE_EVENT_FALLING_EDGE;
            event.line_seqno = sequence;
            events.push_back(event);
        }
    }

    int open(const char* path, int) override {
        path_ = path;
        if (refusals.contains(path_)) {
            return refusals[path_];
        }
        if (path_.starts_with("/sys/")) {
            ++open_descriptors;
            return kFile;
        }
        if (!present || path_ != "/dev/gpiochip0") {
            return -ENOENT;
        }
        ++open_descriptors;
        return kChip;
    }
    int close(int fd) override {
        --open_descriptors;
        if (fd == kLine) {
            line_open_ = false;
            events.clear();
        }
        return 0;
    }
    std::int64_t write(int, const void* buffer, std::size_t size) override {
        writes.push_back(path_ + "=" + std::string(static_cast<const char*>(buffer), size));
        return static_cast<std::int64_t>(size);
    }
    int ioctl(int fd, unsigned long request, void* argument) override {
        if (!present) {
            return -ENODEV;
        }
        if (request == GPIO_GET_CHIPINFO_IOCTL) {
            static_cast<gpiochip_info*>(argument)->lines = 4;
            return 0;
        }
        if (request == GPIO_V2_GET_LINEINFO_IOCTL) {
            auto& info = *static_cast<gpio_v2_line_info*>(argument);
            std::strcpy(info.name, info.offset == 2 ? "CAM_TRIG" : "");
            return 0;
        }
        if (request == GPIO_V2_GET_LINE_IOCTL) {
            auto& line = *static_cast<gpio_v2_line_request*>(argument);
            if (busy) {
                return -EBUSY;
            }
            flags = line.config.flags;
            offset = line.offsets[0];
            debounce_us = line.config.num_attrs == 1 ? line.config.attrs[0].attr.debounce_period_us : 0;
            line.fd = kLine;
            line_open_ = true;
            sequence = 0;
            ++open_descriptors;
            return 0;
        }
        if (request == GPIO_V2_LINE_SET_VALUES_IOCTL && fd == kLine) {
            levels.emplace_back(clock_.now(), (static_cast<gpio_v2_line_values*>(argument)->bits & 1) != 0);
            on_level();
            return 0;
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
        if (!present) {
            return -ENODEV;
        }
        const std::size_t count = std::min(events.size(), size / sizeof(gpio_v2_line_event));
        for (std::size_t i = 0; i < count; ++i) {
            std::memcpy(static_cast<char*>(buffer) + i * sizeof(gpio_v2_line_event), &events.front(),
                        sizeof(gpio_v2_line_event));
            events.pop_front();
        }
        return static_cast<std::int64_t>(count * sizeof(gpio_v2_line_event));
    }

private:
    ManualClock& clock_;
    bool line_open_ = false;
    std::string path_;
};

class GpioHarness final : public test::TriggerHarness {
public:
    explicit GpioHarness(const TriggerGpioOptions& options = {{"/dev/gpiochip0", 1, ""}, {}, {500'000'000}})
        : trigger(kernel, clock, options) {}
    TriggerSource& source() override { return trigger; }
    void offer(int count) override {
        for (int i = 0; i < count; ++i) {
            kernel.edge(stamp_ns += 50'000'000);
        }
    }
    bool break_device() override {
        kernel.present = false;
        return true;
    }
    void repair_device() override {
        kernel.present = true;
        TriggerEdge edge;
        pass_time();
        CHECK(trigger.next({}, edge) == Status::kNotReady);
    }
    void pass_time() override { clock.advance(Duration::from_seconds(0.6)); }

    ManualClock clock{{1'000'000'000}};
    FakeGpio kernel{clock};
    TriggerGpio trigger;
    std::int64_t stamp_ns = 1'000'000'000;
};

TEST_CASE("the GPIO trigger keeps the contract of its port", "[port_conformance]") {
    test::check_source_conformance<test::TriggerHarness>([] { return std::make_unique<GpioHarness>(); });
}

TEST_CASE("a line is found by name and requested as asked, and no descriptor stays behind") {
    TriggerGpioOptions options;
    options.line = {"/dev/gpiochip0", -1, "CAM_TRIG"};
    options.input = {false, true, true, ClockDomain::kRealtime, 150};
    GpioHarness h(options);
    REQUIRE(ok(h.trigger.start()));
    CHECK(h.kernel.offset == 2);
    CHECK(h.kernel.flags == (GPIO_V2_LINE_FLAG_INPUT | GPIO_V2_LINE_FLAG_EDGE_FALLING | GPIO_V2_LINE_FLAG_BIAS_PULL_UP |
                             GPIO_V2_LINE_FLAG_EVENT_CLOCK_REALTIME));
    CHECK(h.kernel.debounce_us == 150);
    CHECK(h.trigger.clock() == ClockDomain::kRealtime);
    CHECK(h.kernel.open_descriptors == 1);
    h.kernel.edge(5, false);
    TriggerEdge edge;
    REQUIRE(h.trigger.next({}, edge) == Status::kOk);
    CHECK_FALSE(edge.rising);
    CHECK(edge.stamp.ns == 5);
    CHECK(edge.sequence == 1);
    h.trigger.stop();
    CHECK(h.kernel.open_descriptors == 0);

    options.input.clock = ClockDomain::kHardware;
    GpioHarness hte(options);
    REQUIRE(ok(hte.trigger.start()));
    CHECK((hte.kernel.flags & (1ULL << 12)) != 0);
    options.input.clock = ClockDomain::kDevice;
    GpioHarness device(options);
    CHECK(device.trigger.start() == Status::kInvalidArgument);
}

TEST_CASE("edges that the kernel had no room for are counted, and the count shows where") {
    GpioHarness h;
    REQUIRE(ok(h.trigger.start()));
    h.offer(70);  // the kernel keeps 64
    const test::Drained first = test::drain(h);
    CHECK(first.stamps.size() == 64);
    h.offer(1);
    TriggerEdge edge;
    REQUIRE(h.trigger.next({}, edge) == Status::kOk);
    CHECK(edge.sequence == 71);
    CHECK(h.trigger.counters().lost == 6);
}

TEST_CASE("the count goes on when the line is opened again") {
    GpioHarness h;
    REQUIRE(ok(h.trigger.start()));
    h.offer(5);
    (void)test::drain(h);
    h.trigger.stop();
    REQUIRE(ok(h.trigger.start()));
    h.offer(1);
    TriggerEdge edge;
    REQUIRE(h.trigger.next({}, edge) == Status::kOk);
    CHECK(edge.sequence == 6);
    CHECK(h.trigger.counters().lost == 0);
}

TEST_CASE("GPIO failures have words") {
    const auto problem_of = [](const GpioLineName& line, bool busy) {
        GpioHarness h({line, {}, {500'000'000}});
        h.kernel.busy = busy;
        CHECK_FALSE(ok(h.trigger.start()));
        CHECK(h.kernel.open_descriptors == 0);
        return std::string(h.trigger.problem());
    };
    CHECK(problem_of({"/dev/gpiochip7", 1, ""}, false) ==
          "/dev/gpiochip7 line 1: the chip cannot be opened: No such file or directory");
    CHECK(problem_of({"/dev/gpiochip0", 4, ""}, false) == "/dev/gpiochip0 line 4: the chip has only 4 lines");
    CHECK(problem_of({"/dev/gpiochip0", -1, "NOPE"}, false) == "/dev/gpiochip0 line 'NOPE': no line has this name");
    CHECK(problem_of({"/dev/gpiochip0", 1, ""}, true) ==
          "/dev/gpiochip0 line 1: in use by another program: Device or resource busy");
}

TEST_CASE("software pulses keep their grid, and leave out what is too late") {
    ManualClock clock({1'000'000'000});
    FakeGpio kernel(clock);
    GpioTriggerOutput output(kernel, clock, {"/dev/gpiochip0", 3, ""});
    std::atomic<bool> stopping{false};
    std::string problem;
    kernel.on_level = [&] {
        if (kernel.levels.size() == 10) {
            clock.advance({120'000'000});  // the thread was away
        }
        stopping = kernel.levels.size() >= 20;
    };
    REQUIRE(output.run({{50'000'000}, {1'000'000}}, stopping, problem) == Status::kOk);
    CHECK(output.pulses() == 10);
    CHECK(output.skipped() == 1);
    for (std::size_t i = 0; i < kernel.levels.size(); ++i) {
        CHECK(kernel.levels[i].second == (i % 2 == 0));
        if (i % 2 == 0 && i != 10) {
            CHECK((kernel.levels[i].first.ns - 1'000'000'000) % 50'000'000 == 0);
        }
    }
    CHECK((kernel.levels[1].first - kernel.levels[0].first).ns == 1'000'000);
    CHECK(kernel.open_descriptors == 0);
    CHECK(output.run({{1}, {1}}, stopping, problem) == Status::kInvalidArgument);
    // A line that cannot be had is known before the first pulse.
    GpioTriggerOutput nowhere(kernel, clock, {"/dev/gpiochip7", 3, ""});
    CHECK_FALSE(ok(nowhere.open(problem)));
    CHECK(problem == "/dev/gpiochip7 line 3: the chip cannot be opened: No such file or directory");
    REQUIRE(ok(output.open(problem)));
    CHECK(kernel.open_descriptors == 1);
    stopping = true;
    CHECK(ok(output.run({{50'000'000}, {1'000'000}}, stopping, problem)));
    CHECK(kernel.open_descriptors == 0);
}

TEST_CASE("a PWM is set up in an order that it accepts") {
    ManualClock clock;
    FakeGpio kernel(clock);
    std::string problem;
    {
        PwmTrigger pwm(kernel, "/sys/class/pwm/pwmchip0", 2);
        REQUIRE(pwm.start({{50'000'000}, {2'000'000}}, problem) == Status::kOk);
    }
    const std::string folder = "/sys/class/pwm/pwmchip0/pwm2/";
    CHECK(kernel.writes == std::vector<std::string>{"/sys/class/pwm/pwmchip0/export=2", folder + "duty_cycle=0",
                                                    folder + "period=50000000", folder + "duty_cycle=2000000",
                                                    folder + "enable=1", folder + "enable=0"});
    PwmTrigger pwm(kernel, "/sys/class/pwm/pwmchip9", 0);
    kernel.refusals["/sys/class/pwm/pwmchip9/export"] = -ENOENT;
    CHECK(pwm.start({}, problem) == Status::kNotFound);
    CHECK(problem == "/sys/class/pwm/pwmchip9/export: No such file or directory");
    CHECK(pwm.start({{1'000}, {2'000}}, problem) == Status::kInvalidArgument);
    CHECK(kernel.open_descriptors == 0);
}

}  // namespace
}  // namespace facet
