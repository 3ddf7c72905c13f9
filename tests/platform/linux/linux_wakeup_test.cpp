// SPDX-License-Identifier: BSD-2-Clause
#include "platform/linux/linux_wakeup.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <thread>

#include "platform/linux/linux_clock.h"

namespace facet::linux_wakeup_test {
namespace {

TEST_CASE("notifications before a wait are taken as one, and without any the wait ends in time") {
    LinuxWakeup wakeup;
    const LinuxClock clock;
    wakeup.notify();
    wakeup.notify();
    CHECK(wakeup.wait(Duration::from_seconds(10.0)));
    const Timestamp begin = clock.now();
    CHECK_FALSE(wakeup.wait(Duration::from_seconds(0.02)));
    CHECK(clock.now() - begin >= Duration::from_seconds(0.02));
    CHECK_FALSE(wakeup.wait({}));
}

TEST_CASE("a notification from another thread ends the wait") {
    LinuxWakeup wakeup;
    LinuxWakeup answer;
    std::atomic<int> value{0};
    std::thread other([&] {
        value = 7;
        wakeup.notify();
        answer.wait(Duration::from_seconds(10.0));
    });
    CHECK(wakeup.wait(Duration::from_seconds(10.0)));
    CHECK(value == 7);
    answer.notify();
    other.join();
}

}  // namespace
}  // namespace facet::linux_wakeup_test
