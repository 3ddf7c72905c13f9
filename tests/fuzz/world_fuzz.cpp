// SPDX-License-Identifier: BSD-2-Clause
// The world stream: any bytes in pieces, and real changes of a world, whole and damaged.
#include <memory>
#include <vector>

#include "drivers/world_stream/world_reader.h"
#include "tests/fuzz/fuzz_input.h"

using namespace facet;
using facet::test::FuzzInput;

namespace {

/// What a planner may rely on, whatever was read.
void check(const WorldState& state) {
    test::require(state.planes.size() <= static_cast<std::size_t>(kWorldPlanes));
    test::require(state.vertices_W.size() == static_cast<std::size_t>(kWorldVertices));
    test::require(state.faces.size() == static_cast<std::size_t>(kWorldFaces));
    test::require(state.cells.size() == static_cast<std::size_t>(kWorldGridBytes));
    test::require(state.levels.size() == static_cast<std::size_t>(kWorldGridBytes));
    test::require(state.confirmed.size() == static_cast<std::size_t>(kWorldRuns));
    for (const WorldFace& face : state.faces) {
        for (const std::uint16_t vertex : face.vertex) {
            test::require(vertex < kWorldVertices);
        }
    }
    static_cast<void>(state.at({0.5, -1e300, 1e9}));
    const WorldPoint corner =
        state.describe({state.low[0] * state.cell_m, state.low[1] * state.cell_m, state.low[2] * state.cell_m});
    test::require(corner.age_s >= 0.0F && corner.certainty >= 0.0F && corner.certainty <= 1.0F);
}

void read_anything(FuzzInput& input) {
    const auto decoder = std::make_unique<WorldDecoder>();
    while (!input.empty()) {
        const std::size_t size = 1 + input.take<std::uint8_t>();
        const std::uint64_t before = decoder->state().sequence;
        const Status status = decoder->add(input.take_bytes(size));
        const bool is_newer = decoder->state().sequence > before;
        test::require(status == Status::kCorrupt || is_newer == ok(status));
    }
    check(decoder->state());
}

/// A finite number, so that states can be compared.
float take_number(FuzzInput& input) { return static_cast<float>(input.take<std::int16_t>()) / 64.0F; }

/// A step of the world as the program makes them.
void change(FuzzInput& input, WorldState& state) {
    state.sequence += 1 + input.take<std::uint8_t>() % 3;
    state.stamp_ns = input.take<std::int64_t>();
    state.resets = input.take<std::uint8_t>();
    state.cell_m = take_number(input);
    state.low = {input.take<std::int32_t>(), input.take<std::int8_t>(), input.take<std::int8_t>()};
    state.planes.resize(input.take<std::uint8_t>() % (kWorldPlanes + 1));
    for (WorldPlane& plane : state.planes) {
        plane = {input.take<std::uint8_t>(), {take_number(input), 0.0F, 1.0F}, take_number(input)};
    }
    for (int n = input.take<std::uint8_t>() % 16; n > 0; --n) {
        state.vertices_W[input.take<std::uint16_t>() % kWorldVertices] = {take_number(input), 1.0F, 2.0F};
        WorldFace& face = state.faces[input.take<std::uint16_t>() % kWorldFaces];
        face = {};
        if (input.take<std::uint8_t>() % 4 != 0) {
            face.vertex = {static_cast<std::uint16_t>(input.take<std::uint16_t>() % kWorldVertices), 1, 2};
            face.sigma_m = take_number(input);
            face.is_used = true;
        }
        state.cells[input.take<std::uint32_t>() % kWorldGridBytes] = input.take<std::uint8_t>();
        state.levels[input.take<std::uint32_t>() % kWorldGridBytes] = input.take<std::uint8_t>();
        state.confirmed[input.take<std::uint32_t>() % kWorldRuns] = input.take<std::uint16_t>();
    }
}

void read_changes(FuzzInput& input) {
    const auto state = std::make_unique<WorldState>();
    const auto read = std::make_unique<WorldState>();
    std::vector<std::uint8_t> message;
    for (int step = 0; step < 4 && !input.empty(); ++step) {
        const auto before = std::make_unique<WorldState>(*state);
        change(input, *state);
        encode_world(step == 0 ? nullptr : before.get(), *state, message);
        std::vector<std::uint8_t> damaged = message;
        damaged[input.take<std::uint32_t>() % damaged.size()] ^= input.take<std::uint8_t>();
        damaged.resize(damaged.size() - input.take<std::uint8_t>() % 2);
        const auto victim = std::make_unique<WorldState>(*read);
        if (!ok(apply_world(damaged, *victim))) {
            test::require(*victim == *read);
        }
        check(*victim);
        test::require(ok(apply_world(message, *read)));
        test::require(*read == *state);
        test::require(apply_world(message, *read) == Status::kOutOfOrder);
    }
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    FuzzInput input(data, size);
    if (input.take<std::uint8_t>() % 2 == 0) {
        read_anything(input);
    } else {
        read_changes(input);
    }
    return 0;
}
