// SPDX-License-Identifier: BSD-2-Clause
#include "app/commands/live_command.h"

#include <catch2/catch.hpp>
#include <set>

#include "app/support/input_error.h"
#include "tests/support/fake_kernel.h"
#include "tests/support/scripted_source.h"

namespace facet::live_command_test {
namespace {

/// A kernel with a PWM, once it is there.
class FakePwm final : public test::FakeKernel {
public:
    bool is_there = false;
    int written = 0;
    int open(const char*, int) override { return is_there ? 7 : -ENOENT; }
    int close(int) override { return 0; }
    std::int64_t write(int, const void*, std::size_t size) override {
        ++written;
        return static_cast<std::int64_t>(size);
    }
};

TEST_CASE("an output that cannot be opened ends the program on the ground, and is waited for in the air") {
    FakePwm kernel;
    ManualClock clock({1'000'000'000});
    Vehicle vehicle;
    for (CameraV4l2Options* camera : {&vehicle.cameras.left, &vehicle.cameras.right}) {
        camera->capture.width = 16;
        camera->capture.height = 8;
    }
    vehicle.imu_spi.emplace();
    vehicle.pulses.emplace();
    vehicle.pulses->pwm_chip = "/sys/class/pwm/pwmchip0";
    Hardware hardware(kernel, clock, vehicle);
    PulseStarter pulses(hardware, vehicle, clock);
    CHECK_THROWS_AS(pulses.begin({}), InputError);
    pulses.begin({}, true);
    pulses.tick();
    kernel.is_there = true;
    pulses.tick();
    CHECK(kernel.written == 0);  // not before a second has passed
    clock.advance(Duration::from_seconds(1.1));
    pulses.tick();
    const int written = kernel.written;
    CHECK(written > 0);
    clock.advance(Duration::from_seconds(1.1));
    pulses.tick();
    CHECK(kernel.written == written);
    end_pulses(hardware);
}

}  // namespace
}  // namespace facet::live_command_test
