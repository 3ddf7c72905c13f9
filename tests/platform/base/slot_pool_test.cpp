// SPDX-License-Identifier: BSD-2-Clause
#include "platform/base/slot_pool.h"

#include <catch2/catch.hpp>
#include <map>
#include <random>

#include "tests/support/allocation_guard.h"

namespace facet::slot_pool_test {
namespace {

using Pool = SlotPool<LandmarkId, int, 50>;

TEST_CASE("a slot pool rejects when full and takes again after an erase", "[slot_pool]") {
    SlotPool<LandmarkId, int, 2> pool;
    const auto a = pool.insert({10});
    const auto b = pool.insert({11});
    REQUIRE(a.ok());
    REQUIRE(b.ok());
    CHECK(a.value() != b.value());
    CHECK(pool.insert({12}).status() == Status::kFull);
    CHECK(pool.size() == 2);
    pool[b.value()] = 5;
    CHECK(pool.erase({11}) == Status::kOk);
    CHECK(pool.erase({11}) == Status::kNotFound);
    CHECK_FALSE(pool.used(b.value()));
    const auto c = pool.insert({12});
    REQUIRE(c.ok());
    CHECK(pool[c.value()] == 0);  // fresh, though the slot is used again
    CHECK(pool.id(c.value()) == LandmarkId{12});
}

TEST_CASE("invalid and duplicate ids are refused", "[slot_pool]") {
    Pool pool;
    CHECK(pool.insert(LandmarkId{}).status() == Status::kInvalidArgument);
    REQUIRE(pool.insert({3}).ok());
    CHECK(pool.insert({3}).status() == Status::kInvalidArgument);
    CHECK(pool.find({4}).status() == Status::kNotFound);
    CHECK(pool.find(LandmarkId{}).status() == Status::kNotFound);
    CHECK(pool.size() == 1);
}

TEST_CASE("a slot pool behaves as a map, and values keep their slots", "[slot_pool]") {
    struct Entry {
        Pool::Slot slot;
        int value;
    };
    Pool pool;
    std::map<std::uint32_t, Entry> model;
    std::mt19937 random(2);  // NOLINT(cert-msc51-cpp): fixed on purpose
    std::uint32_t next_id = 0;
    for (int step = 0; step < 20000; ++step) {
        // Phases of growth and of decline, so that the pool is full and empty now and then.
        const bool grow = random() % 100 < ((step / 500) % 2 == 0 ? 70U : 30U);
        if (grow) {
            next_id += 1 + random() % 3;
            const auto slot = pool.insert({next_id});
            REQUIRE(slot.ok() == (model.size() < Pool::capacity()));
            if (slot.ok()) {
                pool[slot.value()] = step;
                model[next_id] = {slot.value(), step};
            }
        } else if (!model.empty()) {
            auto it = model.begin();
            std::advance(it, static_cast<std::ptrdiff_t>(random() % model.size()));
            REQUIRE(pool.erase({it->first}) == Status::kOk);
            model.erase(it);
        }
        REQUIRE(pool.size() == model.size());
        for (const auto& [id, entry] : model) {
            const auto slot = pool.find({id});
            REQUIRE(slot.ok());
            REQUIRE(slot.value() == entry.slot);
            REQUIRE(pool[slot.value()] == entry.value);
        }
    }
    CHECK(next_id > 10000);
}

TEST_CASE("values are destroyed and made again when a slot is used again", "[slot_pool]") {
    const auto token = std::make_shared<int>(7);
    {
        SlotPool<LandmarkId, std::shared_ptr<int>, 1> pool;
        pool[pool.insert({1}).value()] = token;
        CHECK(token.use_count() == 2);
        REQUIRE(pool.erase({1}) == Status::kOk);
        CHECK(pool[pool.insert({2}).value()] == nullptr);
        CHECK(token.use_count() == 1);
        pool[0] = token;
    }
    CHECK(token.use_count() == 1);
}

TEST_CASE("a slot pool uses no heap", "[slot_pool]") {
    const test::AllocationGuard guard;
    Pool pool;
    for (std::uint32_t i = 0; i < 200; ++i) {
        (void)pool.insert({i});
        if (i >= 25) {
            (void)pool.erase({i - 25});
        }
    }
    const auto allocations = guard.allocations();
    CHECK(pool.size() == 25);
    CHECK(allocations == 0);
}

}  // namespace
}  // namespace facet::slot_pool_test
