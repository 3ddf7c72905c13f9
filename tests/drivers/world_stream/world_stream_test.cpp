// SPDX-License-Identifier: BSD-2-Clause
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <fstream>
#include <limits>
#include <random>
#include <string>
#include <thread>

#include "drivers/world_stream/world_reader.h"
#include "drivers/world_stream/world_server.h"
#include "tests/support/allocation_guard.h"

namespace facet {
namespace {

using Message = std::vector<std::uint8_t>;

/// A world in which some of everything changes from keyframe to keyframe.
class ChangingWorld {
public:
    const WorldState& advance() {
        ++state_.sequence;
        state_.stamp_ns += 50'000'000;
        state_.resets = static_cast<std::uint32_t>(state_.sequence / 7);
        state_.cell_m = 0.1;
        state_.low = {pick(40) - 20, pick(40) - 20, -3};
        ++state_.tick;
        state_.planes.resize(static_cast<std::size_t>(pick(kWorldPlanes + 1)));
        for (WorldPlane& plane : state_.planes) {
            plane = {static_cast<std::uint32_t>(pick(1000)), {0.0F, 0.0F, 1.0F}, static_cast<float>(pick(9))};
        }
        for (int i = 0; i < 200; ++i) {
            const float x = static_cast<float>(pick(1000)) * 0.01F;
            state_.vertices_W[static_cast<std::size_t>(pick(kWorldVertices))] = {x, -x, 0.5F};
            WorldFace& face = state_.faces[static_cast<std::size_t>(pick(kWorldFaces))];
            face = face.is_used && pick(2) == 0 ? WorldFace{} : any_face();
            state_.cells[static_cast<std::size_t>(pick(kWorldGridBytes))] = static_cast<std::uint8_t>(pick(3));
        }
        // Fewer, and of their own blocks: each of the three is reason enough to send a block.
        for (int i = 0; i < 20; ++i) {
            state_.levels[static_cast<std::size_t>(pick(kWorldGridBytes))] = static_cast<std::uint8_t>(pick(256));
            state_.confirmed[static_cast<std::size_t>(pick(kWorldRuns))] = state_.tick;
        }
        return state_;
    }
    const WorldState& state() const { return state_; }

private:
    int pick(int end) { return static_cast<int>(random_() % static_cast<unsigned>(end)); }
    std::uint16_t any_vertex() { return static_cast<std::uint16_t>(pick(kWorldVertices)); }
    WorldFace any_face() {
        return {{any_vertex(), any_vertex(), any_vertex()}, 3, static_cast<std::uint32_t>(pick(5)), 0.01F, true, false};
    }

    std::mt19937 random_{22};
    WorldState state_;
};

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

std::string socket_path() { return "/tmp/facet_world_" + std::to_string(::getpid()); }

void publish(WorldServer& server, const WorldState& state) {
    server.next() = state;
    server.publish();
}

/// Waits until the reader has this keyframe, for some seconds at most.
bool reaches(WorldReader& reader, std::uint64_t sequence) {
    for (int i = 0; i < 50 && reader.state().sequence < sequence; ++i) {
        const Status status = reader.wait(100);
        if (!ok(status) && status != Status::kNotReady) {
            return false;
        }
    }
    return reader.state().sequence == sequence;
}

TEST_CASE("readers of a server have its state at every keyframe, also those that join late") {
    WorldServer server;
    REQUIRE(ok(server.open(socket_path())));
    ChangingWorld world;
    WorldReader early;
    WorldReader late;
    REQUIRE(ok(early.open(socket_path())));
    for (std::uint64_t k = 1; k <= 30; ++k) {
        publish(server, world.advance());
        REQUIRE(reaches(early, k));
        REQUIRE(early.state() == world.state());
        if (k == 15) {
            REQUIRE(ok(late.open(socket_path())));
        }
        if (k >= 15) {
            REQUIRE(reaches(late, k));
            REQUIRE(late.state() == world.state());
        }
    }
    CHECK(early.missed() == 0);
    CHECK(late.missed() == 0);
    CHECK(server.dropped() == 0);
}

TEST_CASE("a reader that does not read costs the publisher nothing, and catches up with a snapshot") {
    WorldServer server;
    REQUIRE(ok(server.open(socket_path())));
    ChangingWorld world;
    WorldReader reader;
    REQUIRE(ok(reader.open(socket_path())));
    publish(server, world.advance());
    REQUIRE(reaches(reader, 1));
    constexpr std::uint64_t kKeyframes = 400;
    for (std::uint64_t k = 2; k <= kKeyframes; ++k) {
        server.next() = world.advance();
        const test::AllocationGuard guard;
        server.publish();
        const std::uint64_t allocations = guard.allocations();
        REQUIRE(allocations == 0);
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    CHECK(server.dropped() > 0);
    REQUIRE(reaches(reader, kKeyframes));
    CHECK(reader.state() == world.state());
    CHECK(reader.missed() > 0);
}

TEST_CASE("the last state arrives when the server closes; the socket is gone") {
    ChangingWorld world;
    WorldReader reader;
    {
        WorldServer server;
        REQUIRE(ok(server.open(socket_path())));
        REQUIRE(ok(reader.open(socket_path())));
        publish(server, world.advance());
        REQUIRE(reaches(reader, 1));
        publish(server, world.advance());
    }
    CHECK(reaches(reader, 2));
    CHECK(reader.state() == world.state());
    CHECK(reader.wait(100) == Status::kEndOfStream);
    CHECK(reader.open(socket_path()) == Status::kIo);
}

TEST_CASE("a path is served once; what a dead program left is replaced, a file is not") {
    WorldServer first;
    REQUIRE(ok(first.open(socket_path())));
    WorldServer second;
    CHECK(second.open(socket_path()) == Status::kFull);
    first.close();
    const int dead = ::socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string path = socket_path();
    std::copy(path.begin(), path.end(), std::begin(address.sun_path));
    REQUIRE(::bind(dead, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0);
    ::close(dead);
    CHECK(ok(second.open(path)));
    second.close();
    CHECK(second.open(std::string(200, 'x')) == Status::kInvalidArgument);
    CHECK(second.open("/tmp") == Status::kFull);
    const std::string file = socket_path() + "_file";
    std::ofstream(file) << "not ours";
    CHECK(second.open(file) == Status::kFull);
    CHECK(::unlink(file.c_str()) == 0);
    CHECK(second.open("/nonexistent/socket") == Status::kIo);
}

}  // namespace
}  // namespace facet
