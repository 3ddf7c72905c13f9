// SPDX-License-Identifier: BSD-2-Clause
#include "platform/base/spsc_queue.h"

#include <catch2/catch.hpp>
#include <memory>
#include <thread>

#include "tests/support/allocation_guard.h"

namespace facet::spsc_queue_test {
namespace {

TEST_CASE("a full queue rejects and counts", "[spsc_queue]") {
    SpscQueue<int, 3> queue;
    for (int i = 0; i < 3; ++i) {
        CHECK(queue.push(i) == Status::kOk);
    }
    CHECK(queue.push(3) == Status::kFull);
    CHECK(queue.push(4) == Status::kFull);
    CHECK(queue.rejected() == 2);
    CHECK(queue.size() == 3);
    int value = -1;
    CHECK(queue.pop(value) == Status::kOk);
    CHECK(value == 0);
    CHECK(queue.push(5) == Status::kOk);
    for (const int expected : {1, 2, 5}) {
        CHECK(queue.pop(value) == Status::kOk);
        CHECK(value == expected);
    }
    CHECK(queue.pop(value) == Status::kNotReady);
    CHECK(value == 5);
}

TEST_CASE("two threads pass every value in order", "[spsc_queue]") {
    constexpr int kCount = 100000;
    SpscQueue<int, 64> queue;
    std::uint64_t refused = 0;
    std::thread producer([&] {
        for (int i = 0; i < kCount;) {
            if (ok(queue.push(i))) {
                ++i;
            } else {
                ++refused;
                std::this_thread::yield();
            }
        }
    });
    bool in_order = true;
    for (int expected = 0; expected < kCount;) {
        int value = -1;
        if (ok(queue.pop(value))) {
            in_order = in_order && value == expected;
            ++expected;
        } else {
            std::this_thread::yield();
        }
    }
    producer.join();
    CHECK(in_order);
    CHECK(queue.rejected() == refused);
    CHECK(queue.size() == 0);
}

TEST_CASE("values that cannot be copied are moved, and destroyed with the queue", "[spsc_queue]") {
    const auto counted = std::make_shared<int>(7);
    const auto own = [&] { return std::make_unique<std::shared_ptr<int>>(counted); };
    {
        SpscQueue<std::unique_ptr<std::shared_ptr<int>>, 2> queue;
        CHECK(queue.push(own()) == Status::kOk);
        CHECK(queue.push(own()) == Status::kOk);
        auto third = own();
        CHECK(queue.push(std::move(third)) == Status::kFull);
        REQUIRE(third != nullptr);  // NOLINT(bugprone-use-after-move): a refused value is untouched
        CHECK(queue.pop(third) == Status::kOk);
        CHECK(**third == 7);
        CHECK(counted.use_count() == 3);
    }
    CHECK(counted.use_count() == 1);
}

TEST_CASE("a queue uses no heap", "[spsc_queue]") {
    const test::AllocationGuard guard;
    SpscQueue<int, 8> queue;
    int value = 0;
    for (int i = 0; i < 100; ++i) {
        (void)queue.push(i);
        (void)queue.pop(value);
    }
    const auto allocations = guard.allocations();
    CHECK(value == 99);
    CHECK(allocations == 0);
}

}  // namespace
}  // namespace facet::spsc_queue_test
