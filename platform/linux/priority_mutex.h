// SPDX-License-Identifier: BSD-2-Clause
// A mutex whose owner runs at the priority of whoever waits for it.
#pragma once

#include <pthread.h>

namespace facet {

/// Like std::mutex (for std::lock_guard and its like), but with priority inheritance (PTHREAD_PRIO_INHERIT): a thread
/// of the ordinary scheduler that holds it cannot be kept from running, and with it a real-time thread that waits, by
/// threads of priorities in between. Thread-safe. No heap.
class PriorityMutex {
public:
    PriorityMutex() {
        pthread_mutexattr_t attributes;
        pthread_mutexattr_init(&attributes);
        pthread_mutexattr_setprotocol(&attributes, PTHREAD_PRIO_INHERIT);
        pthread_mutex_init(&mutex_, &attributes);
        pthread_mutexattr_destroy(&attributes);
    }
    ~PriorityMutex() { pthread_mutex_destroy(&mutex_); }
    PriorityMutex(const PriorityMutex&) = delete;
    PriorityMutex& operator=(const PriorityMutex&) = delete;

    // The names that the standard's locks ask for; none of these can fail for this kind of mutex.
    void lock() { pthread_mutex_lock(&mutex_); }
    void unlock() { pthread_mutex_unlock(&mutex_); }

private:
    pthread_mutex_t mutex_;
};

}  // namespace facet
