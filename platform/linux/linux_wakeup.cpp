// SPDX-License-Identifier: BSD-2-Clause
#include "platform/linux/linux_wakeup.h"

#include <ctime>

#include "platform/base/assert.h"

namespace facet {

LinuxWakeup::LinuxWakeup() { FACET_ASSERT(sem_init(&semaphore_, 0, 0) == 0); }

LinuxWakeup::~LinuxWakeup() { sem_destroy(&semaphore_); }

void LinuxWakeup::notify() { (void)sem_post(&semaphore_); }  // fails only at two thousand million notifications

bool LinuxWakeup::wait(Duration timeout) {
    timespec until{};
    (void)clock_gettime(CLOCK_MONOTONIC, &until);
    const std::int64_t ns = until.tv_nsec + timeout.ns;
    until.tv_sec += static_cast<std::time_t>(ns / 1'000'000'000);
    until.tv_nsec = static_cast<long>(ns % 1'000'000'000);
    if (sem_clockwait(&semaphore_, CLOCK_MONOTONIC, &until) != 0) {
        return false;
    }
    while (sem_trywait(&semaphore_) == 0) {
    }
    return true;
}

}  // namespace facet
