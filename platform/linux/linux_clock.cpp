// SPDX-License-Identifier: BSD-2-Clause
#include "platform/linux/linux_clock.h"

#include <cerrno>
#include <ctime>

namespace facet {
namespace {

constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;

Timestamp read(clockid_t id) {
    timespec t{};
    clock_gettime(id, &t);
    return {static_cast<std::int64_t>(t.tv_sec) * kNanosecondsPerSecond + t.tv_nsec};
}

}  // namespace

Timestamp LinuxClock::now() const { return read(CLOCK_MONOTONIC); }

ClockPair LinuxClock::read_pair() const {
    ClockPair best;
    for (int attempt = 0; attempt < 5; ++attempt) {
        const Timestamp before = read(CLOCK_MONOTONIC);
        const Timestamp realtime = read(CLOCK_REALTIME);
        const Duration half{(read(CLOCK_MONOTONIC) - before).ns / 2};
        if (attempt == 0 || half < best.uncertainty) {
            best = {before + half, realtime, half};
        }
    }
    return best;
}

void LinuxClock::sleep_until(Timestamp until) {
    if (until.ns <= 0) {
        return;
    }
    timespec t{};
    t.tv_sec = static_cast<std::time_t>(until.ns / kNanosecondsPerSecond);
    t.tv_nsec = static_cast<long>(until.ns % kNanosecondsPerSecond);
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) == EINTR) {
    }
}

}  // namespace facet
