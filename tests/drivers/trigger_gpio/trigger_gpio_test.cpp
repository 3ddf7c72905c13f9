// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/trigger_gpio/trigger_gpio.h"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "drivers/trigger_gpio/libgpiod_line.h"
#include "drivers/trigger_gpio/trigger_output.h"
#include "tests/drivers/trigger_gpio/fake_gpio.h"
#include "tests/port_conformance/source_conformance.h"

namespace facet::trigger_gpio_test {
namespace {

using test::FakeGpio;
using test::GpioRequest;

/// Line 1, or the one of the name, by a backend.
GpioLineName line_by(GpioBackend backend, int offset = 1, const char* name = "", const char* chip = FakeGpio::kPath) {
    return {chip, offset, name, backend};
}
TriggerGpioOptions options_for(GpioBackend backend) { return {line_by(backend), {}, {500'000'000}}; }

TriggerGpioOptions judged_options(GpioBackend backend) {
    TriggerGpioOptions options = options_for(backend);
    options.silence = Duration::from_seconds(1.0);
    return options;
}

/// Whether the kernel's numbers of edges, its choice of clocks and of its buffer's size reach us.
bool is_complete(GpioBackend backend) { return backend != GpioBackend::kLibgpiod || LibgpiodLine::kNumbersEdges; }

class GpioHarness final : public test::TriggerHarness {
public:
    explicit GpioHarness(const TriggerGpioOptions& options) : trigger(kernel, clock, options) {}
    TriggerSource& source() override { return trigger; }
    void offer(int count) override {
        for (int i = 0; i < count; ++i) {
            kernel.edge(stamp_ns += 50'000'000);
        }
    }
    test::Hook offer_corrupt() override { return test::Hook::kCannot; }  // an edge is an edge
    test::Hook offer_ahead() override {
        kernel.edge(stamp_ns, true, 3'600'000'000'000);
        return test::Hook::kDone;
    }
    test::Hook break_device() override {
        kernel.present = false;
        return test::Hook::kDone;
    }
    test::Hook judges_silence() override { return test::Hook::kDone; }
    test::Hook end() override { return test::Hook::kCannot; }
    int held_back() const override { return 0; }
    void repair_device() override {
        kernel.present = true;
        TriggerEdge edge;
        pass_time();
        CHECK(trigger.next({}, edge) == Status::kNotReady);
    }
    void pass_time() override {
        clock.advance(Duration::from_seconds(0.6));
        stamp_ns = clock.now().ns;
    }

    ManualClock clock{{1'000'000'000}};
    FakeGpio kernel{clock};
    TriggerGpio trigger;
    std::int64_t stamp_ns = 1'000'000'000;
};

TEST_CASE("the GPIO trigger keeps the contract of its port", "[port_conformance]") {
    const auto backend = GENERATE(GpioBackend::kLibgpiod, GpioBackend::kChardev);
    CAPTURE(static_cast<int>(backend));
    test::check_source_conformance<test::TriggerHarness>(
        [backend] { return std::make_unique<GpioHarness>(judged_options(backend)); });
}

TEST_CASE("a line is found by name and requested as asked, and no descriptor stays behind") {
    const auto backend = GENERATE(GpioBackend::kAuto, GpioBackend::kLibgpiod, GpioBackend::kChardev);
    CAPTURE(static_cast<int>(backend));
    const bool complete = is_complete(backend);
    TriggerGpioOptions options;
    options.line = line_by(backend, -1, "CAM_TRIG");
    options.input = {false, true, true, complete ? ClockDomain::kRealtime : ClockDomain::kMonotonic, 0};
    options.input.debounce_us = complete ? 150 : 0;
    GpioHarness h(options);
    REQUIRE(ok(h.trigger.start()));
    CHECK(h.kernel.requested == GpioRequest{2, false, false, true, true, options.input.clock, options.input.debounce_us,
                                            complete ? 64U : 16U});
    CHECK(h.trigger.clock() == options.input.clock);
    h.kernel.edge(5'000'000'007, false);
    TriggerEdge edge;
    REQUIRE(h.trigger.next({}, edge) == Status::kOk);
    CHECK_FALSE(edge.rising);
    CHECK(edge.stamp.ns == 5'000'000'007);
    CHECK(edge.sequence == 1);
    CHECK(edge.numbered == complete);
    h.trigger.stop();
    CHECK(h.kernel.open_descriptors == 0);
    options.input.rising = true;
    GpioHarness both(options);
    REQUIRE(ok(both.trigger.start()));
    CHECK((both.kernel.requested.rising && both.kernel.requested.falling));
}

TEST_CASE("clocks and debouncing that a backend does not offer are refused with what to do") {
    const auto backend = GENERATE(GpioBackend::kLibgpiod, GpioBackend::kChardev);
    CAPTURE(static_cast<int>(backend));
    TriggerGpioOptions options = options_for(backend);
    const auto start = [&options](std::string& problem, GpioRequest& requested) {
        GpioHarness h(options);
        const Status status = h.trigger.start();
        problem = h.trigger.problem();
        requested = h.kernel.requested;
        return status;
    };
    std::string problem;
    GpioRequest requested;
    options.input.clock = ClockDomain::kDevice;
    CHECK(start(problem, requested) == Status::kInvalidArgument);
    options.input.clock = ClockDomain::kHardware;
    if (is_complete(backend)) {
        CHECK(ok(start(problem, requested)));
        CHECK(requested.clock == ClockDomain::kHardware);
        return;
    }
    CHECK(start(problem, requested) == Status::kInvalidArgument);
    CHECK(problem ==
          "/dev/gpiochip0 line 1: libgpiod 1 stamps edges by the monotonic clock and does not debounce: use "
          "'backend: chardev'");
    options.input = {};
    options.input.debounce_us = 1;
    CHECK(start(problem, requested) == Status::kInvalidArgument);
}

TEST_CASE("edges that the kernel had no room for are counted where they are numbered, and the count shows where") {
    const auto backend = GENERATE(GpioBackend::kLibgpiod, GpioBackend::kChardev);
    CAPTURE(static_cast<int>(backend));
    const bool complete = is_complete(backend);
    GpioHarness h(options_for(backend));
    REQUIRE(ok(h.trigger.start()));
    h.offer(70);
    const test::Drained first = test::drain(h);
    CHECK(first.stamps.size() == (complete ? 64 : 16));
    h.offer(1);
    TriggerEdge edge;
    REQUIRE(h.trigger.next({}, edge) == Status::kOk);
    CHECK(edge.sequence == (complete ? 71 : 17));
    CHECK(h.trigger.counters().lost == (complete ? 6 : 0));
}

TEST_CASE("the count goes on when the line is opened again") {
    const auto backend = GENERATE(GpioBackend::kLibgpiod, GpioBackend::kChardev);
    CAPTURE(static_cast<int>(backend));
    GpioHarness h(options_for(backend));
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

TEST_CASE("a line without edges is requested again, and its count goes on") {
    const auto backend = GENERATE(GpioBackend::kLibgpiod, GpioBackend::kChardev);
    CAPTURE(static_cast<int>(backend));
    TriggerGpioOptions options = options_for(backend);
    options.silence = Duration::from_seconds(0.5);
    GpioHarness h(options);
    REQUIRE(ok(h.trigger.start()));
    h.offer(5);
    CHECK(test::drain(h).stamps.size() == 5);
    h.kernel.requested = {};
    h.clock.advance(Duration::from_seconds(0.6));
    TriggerEdge edge;
    CHECK(h.trigger.next({}, edge) == Status::kIo);
    CHECK(h.trigger.problem() == "/dev/gpiochip0 line 1: no data for 600 ms");
    CHECK(h.trigger.next({}, edge) == Status::kNotReady);
    CHECK(h.kernel.requested.offset == 1);
    h.offer(1);
    REQUIRE(h.trigger.next({}, edge) == Status::kOk);
    CHECK(edge.sequence == 6);
    CHECK(h.trigger.counters().recoveries == 1);
}

TEST_CASE("edges go on after the wall clock that stamps them was set back, and after one that was queued meanwhile") {
    TriggerGpioOptions options = options_for(GpioBackend::kChardev);
    options.input.clock = ClockDomain::kRealtime;
    options.silence = Duration::from_seconds(0.5);
    GpioHarness h(options);
    REQUIRE(ok(h.trigger.start()));
    const auto run = [&h](int edges, Duration offset) {
        h.clock.set_realtime_offset(offset);
        int delivered = 0;
        for (int i = 0; i < edges; ++i) {
            h.clock.advance(Duration::from_seconds(0.05));
            h.kernel.edge(h.clock.now().ns, true, offset.ns);
            delivered += static_cast<int>(test::drain(h).stamps.size());
        }
        return delivered;
    };
    const Duration hour = Duration::from_seconds(3600.0);
    CHECK(run(20, hour + hour) == 20);
    h.kernel.edge(h.clock.now().ns + 1, true, 2 * hour.ns);  // before the step, read after it
    CHECK(run(20, hour) == 20 - (IncreasingStamps::kSetBack - 1));
    CHECK(run(20, hour + hour) == 20);  // set forward: nothing is lost
    CHECK(h.trigger.counters().errors == 0);
}

TEST_CASE("GPIO failures have the same words by every backend") {
    const auto backend = GENERATE(GpioBackend::kLibgpiod, GpioBackend::kChardev);
    CAPTURE(static_cast<int>(backend));
    const auto problem_of = [](const GpioLineName& line, bool busy) {
        GpioHarness h({line, {}, {500'000'000}});
        h.kernel.busy = busy;
        CHECK_FALSE(ok(h.trigger.start()));
        CHECK(h.kernel.open_descriptors == 0);
        return std::string(h.trigger.problem());
    };
    CHECK(problem_of(line_by(backend, 1, "", "/dev/gpiochip7"), false) ==
          "/dev/gpiochip7 line 1: the chip cannot be opened: No such file or directory");
    CHECK(problem_of(line_by(backend, 4), false) == "/dev/gpiochip0 line 4: the chip has only 4 lines");
    CHECK(problem_of(line_by(backend, -1, "NOPE"), false) == "/dev/gpiochip0 line 'NOPE': no line has this name");
    CHECK(problem_of(line_by(backend), true) ==
          "/dev/gpiochip0 line 1: in use by another program: Device or resource busy");
}

TEST_CASE("software pulses keep their grid, and leave out what is too late") {
    const auto backend = GENERATE(GpioBackend::kLibgpiod, GpioBackend::kChardev);
    CAPTURE(static_cast<int>(backend));
    ManualClock clock({1'000'000'000});
    FakeGpio kernel(clock);
    GpioTriggerOutput output(kernel, clock, line_by(backend, 3));
    std::atomic<bool> stopping{false};
    std::string problem;
    kernel.on_level = [&] {
        if (kernel.levels.size() == 10) {
            clock.advance({120'000'000});  // the thread was away
        }
        stopping = kernel.levels.size() >= 20;
    };
    REQUIRE(output.run({{50'000'000}, {1'000'000}}, stopping, problem) == Status::kOk);
    CHECK(kernel.requested.output);
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
    GpioTriggerOutput nowhere(kernel, clock, line_by(backend, 3, "", "/dev/gpiochip7"));
    CHECK_FALSE(ok(nowhere.open(problem)));
    CHECK(problem == "/dev/gpiochip7 line 3: the chip cannot be opened: No such file or directory");
    REQUIRE(ok(output.open(problem)));
    CHECK(kernel.open_descriptors > 0);
    stopping = true;
    CHECK(ok(output.run({{50'000'000}, {1'000'000}}, stopping, problem)));
    CHECK(kernel.open_descriptors == 0);
    // A chip that is pulled out ends the pulses, with words.
    stopping = false;
    kernel.on_level = [&] { kernel.present = false; };
    CHECK_FALSE(ok(output.run({{50'000'000}, {1'000'000}}, stopping, problem)));
    CHECK(problem == "/dev/gpiochip0 line 3: cannot be set: No such device");
}

TEST_CASE("a pulse can be left out, and the others keep their instants") {
    ManualClock clock({1'000'000'000});
    FakeGpio kernel(clock);
    GpioTriggerOutput output(kernel, clock, line_by(GpioBackend::kChardev, 3));
    std::atomic<bool> stopping{false};
    std::string problem;
    kernel.on_level = [&] {
        if (kernel.levels.size() == 4) {
            output.leave_out_next();
        }
        stopping = kernel.levels.size() >= 10;
    };
    REQUIRE(output.run({{50'000'000}, {1'000'000}}, stopping, problem) == Status::kOk);
    CHECK(output.pulses() == 5);
    CHECK(output.skipped() == 0);
    const int expected_ms[] = {0, 50, 150, 200, 250};
    for (std::size_t i = 0; i < 5; ++i) {
        CHECK(kernel.levels[2 * i].first.ns == 1'000'000'000 + expected_ms[i] * 1'000'000LL);
    }
}

TEST_CASE("a PWM pauses, and goes on") {
    ManualClock clock;
    FakeGpio kernel(clock);
    std::string problem;
    PwmTrigger pwm(kernel, "/sys/class/pwm/pwmchip0", 2);
    REQUIRE(pwm.start({{50'000'000}, {2'000'000}}, problem) == Status::kOk);
    kernel.writes.clear();
    REQUIRE(pwm.pause(clock, {100'000'000}, problem) == Status::kOk);
    const std::string enable = "/sys/class/pwm/pwmchip0/pwm2/enable";
    CHECK(kernel.writes == std::vector<std::string>{enable + "=0", enable + "=1"});
    CHECK(clock.now().ns == 100'000'000);
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
}  // namespace facet::trigger_gpio_test
