// SPDX-License-Identifier: BSD-2-Clause
#include "platform/base/arena.h"

#include <Eigen/Core>
#include <array>
#include <catch2/catch.hpp>
#include <limits>

#include "tests/support/allocation_guard.h"

namespace facet {
namespace {

bool aligned(const void* p, std::size_t alignment) { return reinterpret_cast<std::uintptr_t>(p) % alignment == 0; }

TEST_CASE("pieces are aligned, apart and inside the block", "[arena]") {
    alignas(64) std::array<std::byte, 256> storage{};
    Arena arena(std::span<std::byte>(storage).subspan(1));  // not aligned at its start
    auto* a = static_cast<std::byte*>(arena.allocate(10, 8));
    auto* b = static_cast<std::byte*>(arena.allocate(20, 32));
    REQUIRE(a != nullptr);
    REQUIRE(b != nullptr);
    CHECK(aligned(a, 8));
    CHECK(aligned(b, 32));
    CHECK(a >= storage.data() + 1);
    CHECK(b >= a + 10);
    CHECK(b + 20 <= storage.data() + storage.size());
    CHECK(arena.used() == static_cast<std::size_t>(b + 20 - (storage.data() + 1)));
}

TEST_CASE("a full arena gives nothing and changes nothing", "[arena]") {
    alignas(64) std::array<std::byte, 64> storage{};
    Arena arena(storage);
    CHECK(arena.allocate(65, 1) == nullptr);
    CHECK(arena.allocate(std::numeric_limits<std::size_t>::max(), 1) == nullptr);
    CHECK(arena.make_array<double>(std::numeric_limits<std::size_t>::max() / 4).empty());
    CHECK(arena.used() == 0);
    CHECK(arena.allocate(64, 64) == storage.data());
    CHECK(arena.allocate(1, 1) == nullptr);
    CHECK(arena.used() == 64);
    arena.clear();
    CHECK(arena.make_array<double>(8).size() == 8);
    CHECK(arena.make_array<double>(1).empty());
}

TEST_CASE("a scope gives back what was taken in it", "[arena]") {
    alignas(64) std::array<std::byte, 1024> storage{};
    Arena arena(storage);
    (void)arena.make_array<int>(4);
    const Arena::Mark before = arena.mark();
    void* first = nullptr;
    {
        const Arena::Scope scope(arena);
        first = arena.allocate(100, 32);
        CHECK(arena.used() > before);
    }
    CHECK(arena.mark() == before);
    CHECK(arena.high_water() >= before + 100);
    CHECK(arena.allocate(100, 32) == first);
}

TEST_CASE("arrays come value-initialised, aligned for Eigen, without heap", "[arena]") {
    alignas(64) std::array<std::byte, 4096> storage;
    storage.fill(std::byte{0xff});
    const test::AllocationGuard guard;
    Arena arena(storage);
    (void)arena.allocate(3, 1);
    const std::span<double> a = arena.make_array<double>(16);
    const bool zero = a.size() == 16 && Eigen::Map<Eigen::Matrix4d, Eigen::Aligned32>(a.data()).isZero(0.0);
    const auto allocations = guard.allocations();
    CHECK(zero);
    CHECK(aligned(a.data(), 32));
    CHECK(allocations == 0);
}

}  // namespace
}  // namespace facet
