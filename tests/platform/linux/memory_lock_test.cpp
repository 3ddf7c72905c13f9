// SPDX-License-Identifier: BSD-2-Clause
#include "platform/linux/memory_lock.h"

#include <sys/mman.h>
#include <sys/resource.h>

#include <catch2/catch.hpp>
#include <thread>

namespace facet {
namespace {

long minor_faults() {
    rusage usage{};
    getrusage(RUSAGE_THREAD, &usage);
    return usage.ru_minflt;
}

TEST_CASE("memory is locked, or it is said why not") {
    std::string refusal;
    const Status status = lock_memory(refusal);
    if (ok(status)) {
        CHECK(refusal.empty());
        munlockall();
    } else {
        CHECK(status == Status::kIo);
        CHECK(refusal.find("memory not locked: ") == 0);
    }
}

TEST_CASE("a stack that was touched before faults no more") {
    long first = 0;
    long second = 0;
    std::thread thread([&] {
        const long begin = minor_faults();
        prefault_stack(512 * 1024);
        const long touched = minor_faults();
        prefault_stack(512 * 1024);
        first = touched - begin;
        second = minor_faults() - touched;
        prefault_stack(0);
    });
    thread.join();
    CHECK(first > 50);
    CHECK(second < 5);
}

}  // namespace
}  // namespace facet
