// SPDX-License-Identifier: BSD-2-Clause
#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <random>
#include <span>
#include <vector>

#include "drivers/world_stream/world_reader.h"
#include "tests/drivers/world_stream/changing_world.h"

namespace facet::world_stream_test {
namespace {

using Message = std::vector<std::uint8_t>;
using test::ChangingWorld;

Message message_to(const WorldState* base, const WorldState& state) {
    Message message;
    encode_world(base, state, message);
    return message;
}

TEST_CASE("what a decoder has equals what was encoded at every keyframe, however its bytes are cut") {
    const std::size_t cut = GENERATE(1, 35, 36, 37, 4096, 10'000'000);
    ChangingWorld world;
    WorldDecoder decoder;
    WorldState before;
    for (int k = 0; k < 20; ++k) {
        const WorldState& now = world.advance();
        const Message message = message_to(k == 0 ? nullptr : &before, now);
        Status last = Status::kNotReady;
        for (std::size_t i = 0; i < message.size(); i += cut) {
            REQUIRE(last == Status::kNotReady);
            last = decoder.add(std::span(message).subspan(i, std::min(cut, message.size() - i)));
        }
        REQUIRE(last == Status::kOk);
        REQUIRE(decoder.state() == now);
        before = now;
    }
    CHECK(decoder.missed() == 0);
}

TEST_CASE("a delta is much shorter than a snapshot") {
    ChangingWorld world;
    for (int k = 0; k < 100; ++k) {
        world.advance();
    }
    const WorldState before = world.state();
    const WorldState& now = world.advance();
    CHECK(5 * message_to(&before, now).size() < message_to(nullptr, now).size());
}

TEST_CASE("after a loss nothing applies until a snapshot, which counts what was missed") {
    ChangingWorld world;
    WorldDecoder decoder;
    const WorldState first = world.advance();
    const WorldState second = world.advance();
    const WorldState third = world.advance();
    REQUIRE(decoder.add(message_to(nullptr, first)) == Status::kOk);
    CHECK(decoder.add(message_to(&second, third)) == Status::kNotReady);
    CHECK(decoder.out_of_order() == 1);
    CHECK(decoder.state() == first);
    CHECK(decoder.add(message_to(nullptr, third)) == Status::kOk);
    CHECK(decoder.state() == third);
    CHECK(decoder.missed() == 1);
}

TEST_CASE("messages that come again, or late, do not apply") {
    ChangingWorld world;
    WorldDecoder decoder;
    const WorldState first = world.advance();
    const WorldState second = world.advance();
    REQUIRE(decoder.add(message_to(nullptr, first)) == Status::kOk);
    REQUIRE(decoder.add(message_to(&first, second)) == Status::kOk);
    CHECK(decoder.add(message_to(&first, second)) == Status::kNotReady);
    CHECK(decoder.add(message_to(nullptr, first)) == Status::kNotReady);
    CHECK(decoder.state() == second);
    CHECK(decoder.out_of_order() == 2);
}

TEST_CASE("lengths beyond any message, other versions and other bytes end a stream at the header") {
    ChangingWorld world;
    Message message = message_to(nullptr, world.advance());
    const std::size_t place = GENERATE(0, 4, 11);  // magic, version, highest byte of the length
    message[place] ^= 0x7fU;
    WorldDecoder decoder;
    CHECK(decoder.add(message) == Status::kCorrupt);
    CHECK(decoder.add(message_to(nullptr, world.state())) == Status::kCorrupt);
    CHECK(decoder.state() == WorldState());
}

TEST_CASE("a message without a payload ends a stream") {
    ChangingWorld world;
    Message message = message_to(nullptr, world.advance());
    std::fill(message.begin() + 8, message.begin() + 12, std::uint8_t{0});
    WorldDecoder decoder;
    CHECK(decoder.add(message) == Status::kCorrupt);
}

TEST_CASE("a message with any byte changed or cut off is refused whole, or read within bounds") {
    ChangingWorld world;
    const WorldState first = world.advance();
    const Message message = message_to(nullptr, first);
    std::mt19937 random(1);
    int refused = 0;
    for (int i = 0; i < 2000; ++i) {
        Message bad = message;
        for (int hits = 0; hits < 4; ++hits) {
            bad[random() % bad.size()] = static_cast<std::uint8_t>(random());
        }
        WorldState state;
        if (!ok(apply_world(bad, state))) {
            ++refused;
            REQUIRE(state.sequence == 0);
        }
        REQUIRE(state.planes.size() <= static_cast<std::size_t>(kWorldPlanes));
        REQUIRE(std::all_of(state.faces.begin(), state.faces.end(), [](const WorldFace& face) {
            return std::all_of(face.vertex.begin(), face.vertex.end(), [](int v) { return v < kWorldVertices; });
        }));
    }
    CHECK(refused > 100);
    WorldState state;
    for (std::size_t size = 0; size < message.size(); size += 97) {
        REQUIRE(apply_world(std::span(message).first(size), state) == Status::kCorrupt);
    }
    CHECK(state == WorldState());
}

TEST_CASE("the longest message fits its bound") {
    WorldState full;
    full.sequence = 1;
    full.planes.resize(kWorldPlanes);
    std::fill(full.vertices_W.begin(), full.vertices_W.end(), std::array<float, 3>{1.0F, 1.0F, 1.0F});
    std::fill(full.faces.begin(), full.faces.end(), WorldFace{{0, 1, 2}, 1, 1, 1.0F, true, false});
    std::fill(full.cells.begin(), full.cells.end(), std::uint8_t{0x55});
    const Message message = message_to(nullptr, full);
    CHECK(message.size() == kWorldHeaderBytes + kMaxWorldPayload);
    WorldDecoder decoder;
    CHECK(decoder.add(message) == Status::kOk);
    CHECK(decoder.state() == full);
    CHECK(decoder.state().at({0.0, 0.0, 0.0}) == WorldSpace::kUnknown);  // no grid
}

TEST_CASE("a point's space is found by its cell, unknown outside") {
    WorldState world;
    world.cell_m = 0.1;
    world.low = {-4, -4, -4};
    const std::size_t index = ((63 * 128) + 126) * 128 + 125;  // cell (-3, -2, -1)
    world.cells[index / 4] = static_cast<std::uint8_t>(2U << (2 * (index % 4)));
    CHECK(world.at({-0.25, -0.15, -0.05}) == WorldSpace::kOccupied);
    CHECK(world.at({-0.15, -0.15, -0.05}) == WorldSpace::kUnknown);
    world.cells[index / 4] = static_cast<std::uint8_t>(1U << (2 * (index % 4)));
    CHECK(world.at({-0.25, -0.15, -0.05}) == WorldSpace::kFree);
    CHECK(world.at({-0.25 + 12.8, -0.15, -0.05}) == WorldSpace::kUnknown);
    CHECK(world.at({std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0}) == WorldSpace::kUnknown);
}

}  // namespace
}  // namespace facet::world_stream_test
