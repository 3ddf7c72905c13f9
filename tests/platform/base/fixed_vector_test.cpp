// SPDX-License-Identifier: BSD-2-Clause
#include "platform/base/fixed_vector.h"

#include <catch2/catch.hpp>
#include <memory>
#include <numeric>
#include <span>
#include <vector>

#include "tests/support/allocation_guard.h"

namespace facet::fixed_vector_test {
namespace {

int sum(std::span<const int> values) { return std::accumulate(values.begin(), values.end(), 0); }

TEST_CASE("a fixed vector rejects when full and stays as it was", "[fixed_vector]") {
    FixedVector<int, 3> v;
    CHECK(v.empty());
    for (int i = 1; i <= 3; ++i) {
        CHECK(v.try_push_back(i) == Status::kOk);
    }
    CHECK(v.full());
    CHECK(v.try_push_back(4) == Status::kFull);
    CHECK(v.size() == 3);
    CHECK(v.front() == 1);
    CHECK(v.back() == 3);
}

TEST_CASE("a fixed vector converts to a span", "[fixed_vector]") {
    FixedVector<int, 8> v;
    for (int i = 0; i < 5; ++i) {
        v.push_back(i);
    }
    CHECK(sum(v) == 10);
    for (int& x : v) {
        x *= 2;
    }
    CHECK(sum(v) == 20);
}

TEST_CASE("removal keeps the order", "[fixed_vector]") {
    FixedVector<int, 5> v;
    for (int i = 0; i < 5; ++i) {
        v.push_back(i);
    }
    v.erase_at(1);
    CHECK(std::vector<int>(v.begin(), v.end()) == std::vector<int>{0, 2, 3, 4});
    v.erase_at(3);
    CHECK(std::vector<int>(v.begin(), v.end()) == std::vector<int>{0, 2, 3});
    v.pop_back();
    v.resize(4);
    CHECK(std::vector<int>(v.begin(), v.end()) == std::vector<int>{0, 2, 0, 0});
    v.clear();
    CHECK(v.empty());
}

TEST_CASE("elements live exactly as long as they are in the vector", "[fixed_vector]") {
    const auto token = std::make_shared<int>(7);
    {
        FixedVector<std::shared_ptr<int>, 4> v;
        v.push_back(token);
        v.push_back(token);
        CHECK(token.use_count() == 3);
        v.erase_at(0);
        CHECK(token.use_count() == 2);
    }
    CHECK(token.use_count() == 1);
}

TEST_CASE("a fixed vector uses no heap", "[fixed_vector]") {
    const test::AllocationGuard guard;
    FixedVector<int, 100> v;
    while (!v.full()) {
        v.push_back(1);
    }
    const FixedVector<int, 100> copy = v;
    const int total = sum(copy);
    const auto allocations = guard.allocations();
    CHECK(total == 100);
    CHECK(allocations == 0);
}

}  // namespace
}  // namespace facet::fixed_vector_test
