// SPDX-License-Identifier: BSD-2-Clause
#include "platform/base/ring_buffer.h"

#include <catch2/catch.hpp>
#include <deque>
#include <random>

#include "tests/support/allocation_guard.h"

namespace facet::ring_buffer_test {
namespace {

TEST_CASE("a full ring buffer drops the oldest and counts it", "[ring_buffer]") {
    RingBuffer<int, 3> ring;
    for (int i = 1; i <= 5; ++i) {
        ring.push(i);
    }
    CHECK(ring.full());
    CHECK(ring.dropped() == 2);
    CHECK(ring.front() == 3);
    CHECK(ring[1] == 4);
    CHECK(ring.back() == 5);
    ring.clear();
    CHECK(ring.empty());
    CHECK(ring.dropped() == 0);
}

TEST_CASE("a ring buffer behaves as a deque that is cut at its front", "[ring_buffer]") {
    RingBuffer<int, 7> ring;
    std::deque<int> model;
    std::mt19937 random(1);  // NOLINT(cert-msc51-cpp): fixed on purpose
    for (int step = 0; step < 2000; ++step) {
        const auto dice = random() % 10;
        if (dice < 7) {
            ring.push(step);
            model.push_back(step);
            if (model.size() > 7) {
                model.pop_front();
            }
        } else {
            const std::size_t n = random() % (model.size() + 1);
            ring.pop_front(n);
            model.erase(model.begin(), model.begin() + static_cast<std::ptrdiff_t>(n));
        }
        REQUIRE(ring.size() == model.size());
        for (std::size_t i = 0; i < model.size(); ++i) {
            REQUIRE(ring[i] == model[i]);
        }
    }
}

TEST_CASE("a ring buffer uses no heap", "[ring_buffer]") {
    const test::AllocationGuard guard;
    RingBuffer<int, 16> ring;
    for (int i = 0; i < 100; ++i) {
        ring.push(i);
    }
    const auto allocations = guard.allocations();
    CHECK(ring.front() == 84);
    CHECK(allocations == 0);
}

}  // namespace
}  // namespace facet::ring_buffer_test
