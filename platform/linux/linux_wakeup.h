// SPDX-License-Identifier: BSD-2-Clause
// Lets a thread sleep until another has something for it.
#pragma once

#include <semaphore.h>

#include "platform/base/timestamp.h"

namespace facet {

/// A Linux semaphore. notify() takes no lock, so that no thread waits for one of lower priority. Thread-safe. No heap.
class LinuxWakeup {
public:
    LinuxWakeup();
    ~LinuxWakeup();
    LinuxWakeup(const LinuxWakeup&) = delete;
    LinuxWakeup& operator=(const LinuxWakeup&) = delete;

    /// Wakes the waiting thread, or lets the next wait return at once.
    void notify();
    /// One thread only. Returns after a notification (several are taken as one) or the timeout, seldom before.
    /// @return whether there was a notification
    bool wait(Duration timeout);

private:
    sem_t semaphore_;
};

}  // namespace facet
