// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/replay_asl/png_arena.h"

#include <catch2/catch.hpp>
#include <cstdint>
#include <cstring>
#include <utility>
#include <vector>

#include "tests/support/allocation_guard.h"

namespace facet::png_arena_test {
namespace {

TEST_CASE("pieces of an arena are aligned and do not overlap, from the heap or not") {
    PngArena arena;
    for (int round = 0; round < 3; ++round) {
        arena.reset();
        std::vector<std::pair<unsigned char*, std::size_t>> pieces;
        for (std::size_t size : {std::size_t{0}, std::size_t{1}, std::size_t{17}, std::size_t{4000}, std::size_t{3}}) {
            auto* const piece = static_cast<unsigned char*>(arena.allocate(size));
            REQUIRE(piece != nullptr);
            CHECK(reinterpret_cast<std::uintptr_t>(piece) % alignof(std::max_align_t) == 0);
            std::memset(piece, static_cast<int>(pieces.size()), size);
            pieces.emplace_back(piece, size);
        }
        for (std::size_t i = 0; i < pieces.size(); ++i) {
            const auto [piece, size] = pieces[i];
            CHECK(std::vector<unsigned char>(piece, piece + size) ==
                  std::vector<unsigned char>(size, static_cast<unsigned char>(i)));
            arena.free(piece);
        }
    }
}

TEST_CASE("what an image needed once is there for the next, up to a limit") {
    if (!test::AllocationGuard::active()) {
        return;
    }
    PngArena arena;
    const auto calls = [&arena](std::size_t size) {
        arena.reset();
        const test::AllocationGuard guard;
        void* const first = arena.allocate(size);
        void* const second = arena.allocate(size);
        const std::uint64_t allocations = guard.allocations();
        arena.free(first);
        arena.free(second);
        return allocations;
    };
    CHECK(calls(1000) == 2);
    CHECK(calls(1000) == 0);
    CHECK(calls(500) == 0);
    CHECK(calls(1200) == 1);  // the second one does not fit
    CHECK(calls(1200) == 0);
    CHECK(calls(PngArena::kMaxBytes) == 2);
    CHECK(calls(PngArena::kMaxBytes) == 1);      // as much as the arena may hold
    CHECK(calls(PngArena::kMaxBytes + 1) == 2);  // never
}

}  // namespace
}  // namespace facet::png_arena_test
