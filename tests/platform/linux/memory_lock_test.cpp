// SPDX-License-Identifier: BSD-2-Clause
#include "platform/linux/memory_lock.h"

#include <pthread.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <vector>

#include "tests/support/sanitizers.h"

namespace facet::memory_lock_test {
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

TEST_CASE("what was allocated and never touched is there once memory is locked") {
    constexpr std::size_t kPages = 256;
    constexpr std::size_t kPage = 4096;
    void* const memory = mmap(nullptr, kPages * kPage, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    REQUIRE(memory != MAP_FAILED);
    const auto resident = [&] {
        std::vector<unsigned char> there(kPages);
        REQUIRE(mincore(memory, kPages * kPage, there.data()) == 0);
        return std::count_if(there.begin(), there.end(), [](unsigned char page) { return (page & 1U) != 0; });
    };
    REQUIRE(resident() == 0);
    std::string refusal;
    if (ok(lock_memory(refusal)) && !test::kSanitized) {
        CHECK(resident() == static_cast<std::ptrdiff_t>(kPages));
        const long before = minor_faults();
        std::memset(memory, 1, kPages * kPage);
        CHECK(minor_faults() - before < 5);
        munlockall();
    }
    munmap(memory, kPages * kPage);
}

struct StackFaults {
    long first = 0;
    long second = 0;
};

void* touch_stack_twice(void* argument) {
    auto& faults = *static_cast<StackFaults*>(argument);
    const long begin = minor_faults();
    prefault_stack(512 * 1024);
    const long touched = minor_faults();
    prefault_stack(512 * 1024);
    faults.first = touched - begin;
    faults.second = minor_faults() - touched;
    prefault_stack(0);
    return nullptr;
}

TEST_CASE("a stack that was touched before faults no more") {
    // A stack of its own, in small pages: the C library hands the stacks of threads that have ended on, touched.
    constexpr std::size_t kStack = std::size_t{2} << 20U;
    void* const stack = mmap(nullptr, kStack, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_STACK, -1, 0);
    REQUIRE(stack != MAP_FAILED);
    static_cast<void>(madvise(stack, kStack, MADV_NOHUGEPAGE));
    pthread_attr_t attributes;
    REQUIRE(pthread_attr_init(&attributes) == 0);
    REQUIRE(pthread_attr_setstack(&attributes, stack, kStack) == 0);
    StackFaults faults;
    pthread_t thread{};
    REQUIRE(pthread_create(&thread, &attributes, touch_stack_twice, &faults) == 0);
    REQUIRE(pthread_join(thread, nullptr) == 0);
    pthread_attr_destroy(&attributes);
    munmap(stack, kStack);
    CHECK(faults.first > 50);
    CHECK(faults.second < 5);
}

}  // namespace
}  // namespace facet::memory_lock_test
