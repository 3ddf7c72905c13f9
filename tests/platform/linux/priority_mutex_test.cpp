// SPDX-License-Identifier: BSD-2-Clause
#include "platform/linux/priority_mutex.h"

#include <sched.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <fstream>
#include <mutex>
#include <sstream>
#include <string>
#include <thread>

namespace facet::priority_mutex_test {
namespace {

/// The priority that the kernel runs a thread at now: below -1 for the real-time scheduler.
int priority_of(long thread) {
    std::ifstream file("/proc/self/task/" + std::to_string(thread) + "/stat");
    std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    std::istringstream fields(text.substr(text.rfind(')') + 1));
    std::string field;
    for (int i = 0; i < 16; ++i) {  // state is the third field, priority the eighteenth
        fields >> field;
    }
    return std::stoi(field);
}

bool become_real_time(int priority) {
    const sched_param wanted{priority};
    return sched_setscheduler(0, SCHED_FIFO, &wanted) == 0;
}

TEST_CASE("it locks out others") {
    PriorityMutex mutex;
    int count = 0;
    const auto work = [&] {
        for (int i = 0; i < 20'000; ++i) {
            const std::lock_guard lock(mutex);
            ++count;
        }
    };
    std::thread a(work);
    std::thread b(work);
    a.join();
    b.join();
    CHECK(count == 40'000);
}

TEST_CASE("who holds it runs at the priority of who waits for it") {
    constexpr int kPriority = 30;
    PriorityMutex mutex;
    std::atomic<bool> is_real_time{false};
    std::atomic<bool> is_refused{false};
    const long holder = syscall(SYS_gettid);
    const int before = priority_of(holder);
    mutex.lock();
    std::thread waiter([&] {
        is_refused = !become_real_time(kPriority);
        is_real_time = true;
        const std::lock_guard lock(mutex);
    });
    while (!is_real_time) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    int boosted = before;
    for (int i = 0; i < 2000 && !is_refused && boosted == before; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        boosted = priority_of(holder);
    }
    mutex.unlock();
    waiter.join();
    if (is_refused) {
        WARN("no right to real-time priorities here: inheritance was not tried");
        return;
    }
    CHECK(boosted == -1 - kPriority);
    CHECK(priority_of(holder) == before);
}

}  // namespace
}  // namespace facet::priority_mutex_test
