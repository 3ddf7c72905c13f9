// SPDX-License-Identifier: BSD-2-Clause
// Scenes with full geometry but coarse textures and light, quick to prepare; each is built once per test program.
#pragma once

#include "app/lab/sim/scene.h"

namespace facet::sim {

inline const SceneDetail kDraft{64, 0.8, 4, 1};

inline const Scene& draft_scene(std::string_view name) {
    static const Scene room = make_scene("room", kDraft);
    if (name == "room") {
        return room;
    }
    if (name == "building") {
        static const Scene building = make_scene("building", kDraft);
        return building;
    }
    static const Scene hall = make_scene("hall", kDraft);
    return hall;
}

}  // namespace facet::sim
