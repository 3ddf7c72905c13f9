// SPDX-License-Identifier: BSD-2-Clause
#include "platform/base/slot_lease.h"

#include <array>
#include <catch2/catch.hpp>
#include <thread>
#include <type_traits>

#include "platform/base/spsc_queue.h"
#include "tests/support/allocation_guard.h"

namespace facet::slot_lease_test {
namespace {

static_assert(!std::is_copy_constructible_v<SlotLease> && !std::is_copy_assignable_v<SlotLease>);
static_assert(std::is_nothrow_move_constructible_v<SlotLease> && std::is_nothrow_move_assignable_v<SlotLease>);

TEST_CASE("a slot is lent until its lease is destroyed, and lent again then", "[slot_lease]") {
    SlotLender<2> lender;
    {
        const SlotLease first = lender.take();
        const SlotLease second = lender.take();
        CHECK(first.held());
        CHECK(first.slot() == 0);
        CHECK(second.slot() == 1);
        CHECK(lender.lent() == 2);
        const SlotLease none = lender.take();
        CHECK_FALSE(none.held());
        CHECK(none.slot() == -1);
    }
    CHECK(lender.lent() == 0);
    CHECK(lender.take().slot() == 0);
}

TEST_CASE("a moved-from lease holds nothing", "[slot_lease]") {
    SlotLender<2> lender;
    SlotLease first = lender.take();
    SlotLease moved = std::move(first);
    CHECK_FALSE(first.held());  // NOLINT(bugprone-use-after-move): what is tested
    CHECK(first.slot() == -1);
    CHECK(moved.slot() == 0);
    CHECK(lender.lent() == 1);
    first.release();
    CHECK(lender.lent() == 1);
}

TEST_CASE("assigning to a lease ends the one before, not the one assigned", "[slot_lease]") {
    SlotLender<3> lender;
    SlotLease lease = lender.take();
    lease = lender.take();
    CHECK(lease.slot() == 1);
    CHECK(lender.lent() == 1);
    SlotLease& itself = lease;
    lease = std::move(itself);
    CHECK(lease.slot() == 1);
    CHECK(lender.lent() == 1);
    lease = {};
    CHECK(lender.lent() == 0);
}

TEST_CASE("releasing twice frees a slot once", "[slot_lease]") {
    SlotLender<1> lender;
    SlotLease early = lender.take();
    early.release();
    SlotLease later = lender.take();
    early.release();
    CHECK(later.held());
    CHECK(lender.lent() == 1);
}

TEST_CASE("a shared slot is free when all of its leases have ended", "[slot_lease]") {
    SlotLender<1> lender;
    SlotLease left = lender.take();
    SlotLease right = left.share();
    CHECK(right.slot() == left.slot());
    left.release();
    CHECK(lender.lent() == 1);
    CHECK_FALSE(lender.take().held());
    right.release();
    CHECK(lender.lent() == 0);
    CHECK_FALSE(SlotLease().share().held());
}

TEST_CASE("leases that stay in a queue end with it", "[slot_lease]") {
    SlotLender<4> lender;
    {
        SpscQueue<SlotLease, 2> queue;
        REQUIRE(ok(queue.push(lender.take())));
        REQUIRE(ok(queue.push(lender.take())));
        SlotLease refused = lender.take();
        CHECK(queue.push(std::move(refused)) == Status::kFull);
        CHECK(refused.slot() == 2);  // NOLINT(bugprone-use-after-move): a refused value is untouched
        SlotLease first;
        REQUIRE(ok(queue.pop(first)));
        CHECK(first.slot() == 0);
        CHECK(lender.lent() == 3);
    }
    CHECK(lender.lent() == 0);
}

TEST_CASE("a slot is written only after its reader on another thread is done with it", "[slot_lease]") {
    constexpr int kCount = 20000;
    struct Message {
        int value = -1;
        SlotLease lease;
    };
    SlotLender<3> lender;
    std::array<int, 3> content{};
    SpscQueue<Message, 4> queue;
    std::thread owner([&] {
        for (int i = 0; i < kCount;) {
            SlotLease lease = lender.take();
            if (!lease.held()) {
                std::this_thread::yield();
                continue;
            }
            content[static_cast<std::size_t>(lease.slot())] = i;
            while (!ok(queue.push({i, lease.share()}))) {
                std::this_thread::yield();
            }
            ++i;
        }
    });
    int wrong = 0;
    for (int taken = 0; taken < kCount;) {
        Message message;
        if (!ok(queue.pop(message))) {
            std::this_thread::yield();
            continue;
        }
        wrong +=
            content[static_cast<std::size_t>(message.lease.slot())] == message.value && message.value == taken ? 0 : 1;
        ++taken;
    }
    owner.join();
    CHECK(wrong == 0);
    CHECK(lender.lent() == 0);
}

TEST_CASE("leases use no heap", "[slot_lease]") {
    const test::AllocationGuard guard;
    SlotLender<2> lender;
    for (int i = 0; i < 100; ++i) {
        SlotLease lease = lender.take();
        SlotLease other = lease.share();
        lease = std::move(other);
    }
    CHECK(guard.allocations() == 0);
}

}  // namespace
}  // namespace facet::slot_lease_test
