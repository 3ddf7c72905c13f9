// SPDX-License-Identifier: BSD-2-Clause
// What tests of the world stream send.
#pragma once

#include <cstdint>
#include <random>

#include "drivers/world_stream/world_message.h"

namespace facet::test {

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

}  // namespace facet::test
